/* The parts of a scene file, each read into its part of the scene. Errors go to the reader. */
#ifndef SDR_SCENE_SECTIONS_H
#define SDR_SCENE_SECTIONS_H

#include "scene/reader.h"

typedef enum {
  SDR_REGION_UNREAD,
  SDR_REGION_OPEN,
  SDR_REGION_READ,
  SDR_REGION_BAD
} sdr_region_state;

/* One scene being read. */
typedef struct {
  sdr_reader *reader;
  sdr_scene *scene;
  sdr_node *root;
  sdr_node *regions;       /* the mapping of regions, NULL if there is none */
  sdr_region_state *state; /* per region, beside scene->region */
} sdr_reading;

/* Units and ranges used in several sections. */
#define SDR_LENGTH ((sdr_unit){1, 0, 0, 0})
#define SDR_AREA ((sdr_unit){2, 0, 0, 0})
#define SDR_TIME ((sdr_unit){0, 0, 1, 0})
#define SDR_STRESS ((sdr_unit){-1, 1, -2, 0})
#define SDR_PLAIN ((sdr_unit){0, 0, 0, 0})
#define SDR_ANY_VALUE(unit) ((sdr_quantity){unit, -INFINITY, INFINITY, 0, 0})
#define SDR_ABOVE_ZERO(unit) ((sdr_quantity){unit, 0, INFINITY, 1, 0})
#define SDR_FROM_ZERO(unit) ((sdr_quantity){unit, 0, INFINITY, 0, 0})

/* Room for the items of a list; NULL (fatal noted) if memory runs out. */
void *sdr_reading_room(sdr_reading *reading, const sdr_node *list, size_t size);

/* shapes.c */
int sdr_is_shape_word(const char *word);
/* A shape; NULL if it is in error. `beside`: a key that may stand beside the shape's, or NULL. */
sdr_shape *sdr_read_shape(sdr_reading *reading, sdr_node *node, const char *beside);

/* import.c: the file of `points.import`, if there is one; before the regions, which may name its
   groups. */
void sdr_read_import(sdr_reading *reading);
/* The shape of a group of the imported file; NULL: none of that name. */
sdr_shape *sdr_imported_shape(const sdr_reading *reading, const char *name);

/* places.c */
typedef enum { SDR_ANY_PLACE, SDR_VOLUME_PLACE, SDR_FACE_PLACE } sdr_place_kind;
void sdr_read_regions(sdr_reading *reading);
/* The shape of a region; NULL (with an error) if there is none or it is in error. */
sdr_shape *sdr_read_region(sdr_reading *reading, const sdr_node *node, const char *name);
int sdr_read_place_node(sdr_reading *reading, sdr_node *node, sdr_place_kind kind, sdr_place *out);
int sdr_read_place(sdr_reading *reading, sdr_node *map, const char *key, sdr_place_kind kind,
                   const char *fallback, sdr_place *out);
/* Names of a shape's faces, "left, right"; "" if it has none. In a thread-local buffer. */
const char *sdr_shape_face_list(const sdr_shape *shape, sdr_dimension dimension);

/* points.c, family.c, material.c, damage.c, cracks.c, conditions.c, run.c */
void sdr_read_points(sdr_reading *reading);
void sdr_read_adapt(sdr_reading *reading, sdr_node *points); /* adapt.c: its mapping `adapt` */
void sdr_check_adapt(sdr_reading *reading);                  /* refuse it where it cannot be done */
void sdr_read_model(sdr_reading *reading);  /* of the first material; its errors come later */
void sdr_read_family(sdr_reading *reading); /* after model */
void sdr_read_damage(sdr_reading *reading); /* after model */
/* 1 if the scene wants no damage law; a law that is in error is one. */
int sdr_is_lawless(const sdr_reading *reading);
void sdr_read_materials(sdr_reading *reading); /* after damage: the law decides on toughness */
/* Words for models, in the order of sdr_model_kind, ended by NULL. */
extern const char *const sdr_model_words[];
void sdr_read_cracks(sdr_reading *reading);
void sdr_read_initial(sdr_reading *reading);
void sdr_read_loads(sdr_reading *reading);
void sdr_read_supports(sdr_reading *reading);
void sdr_read_time(sdr_reading *reading);
void sdr_read_static(sdr_reading *reading, sdr_node *map); /* static.c: the mapping `time` of one */
/* The mapping `time` of one that chooses its steps; its keys, where another integrator reads them.
   adaptive.c */
void sdr_read_adaptive(sdr_reading *reading, sdr_node *map);
void sdr_allow_adaptive(sdr_reading *reading, sdr_node *map);
void sdr_check_masses(sdr_reading *reading); /* refuse points without mass where they cannot move */
void sdr_read_energy_momentum(sdr_reading *reading, sdr_node *map); /* midpoint.c: likewise */
void sdr_read_contact(sdr_reading *reading);                        /* contact.c; after time */
void sdr_read_output(sdr_reading *reading); /* after time, points and damage */
/* The mapping `measures` of `output`. measures.c */
void sdr_read_measures(sdr_reading *reading, sdr_node *output);
/* The mapping `cracks` of `output`. crack_observers.c */
void sdr_read_crack_tips(sdr_reading *reading, sdr_node *output);
void sdr_read_figures(sdr_reading *reading);
/* idle.c: note what nothing looks at; after all others. */
void sdr_find_idle(sdr_reading *reading);
/* equation.c: all of a scene with an equation but title, regions, points and figures. */
void sdr_read_equation(sdr_reading *reading);

#endif
