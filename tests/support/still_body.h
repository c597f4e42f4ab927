/* A body of support/body.h as a system of equations without loads and supports. */
#ifndef SDR_TESTS_STILL_BODY_H
#define SDR_TESTS_STILL_BODY_H

#include "mechanics/system.h"
#include "support/body.h"

typedef struct {
  body body;
  sdr_scene scene;
  sdr_loads *loads;
  sdr_supports *supports;
  sdr_system *system;
} still_body;

static const double still_density[2] = {2500.0, 4000.0}; /* kg/m^3, of both materials */

/* Takes the body over. */
static inline void still_of(body b, still_body *s)
{
  *s = (still_body){.body = b};
  s->scene.dimension = b.how.dimension;
  assert_int_equal(sdr_loads_create(&s->scene, s->body.points, &s->loads), SDR_OK);
  assert_int_equal(sdr_supports_create(&s->scene, s->body.points, &s->supports), SDR_OK);
  assert_int_equal(
      sdr_system_create(s->body.model, still_density, s->loads, s->supports, &s->system), SDR_OK);
}

static inline void still_create(const body_how *how, still_body *s)
{
  still_of(body_create(how), s);
}

static inline void still_destroy(still_body *s)
{
  sdr_system_destroy(&s->system);
  sdr_supports_destroy(&s->supports);
  sdr_loads_destroy(&s->loads);
  body_destroy(&s->body);
}

#endif
