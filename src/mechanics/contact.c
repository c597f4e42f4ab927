#include "mechanics/contact.h"

#include "base/memory.h"
#include "base/parallel.h"
#include "mechanics/contact_internal.h"
#include "nom/neighbourhood.h"

#include <math.h>

/* In spacings: how far apart pairs are kept beyond their d; longer where things move fast. */
static const double first_skin = 0.4, least_skin = 0.2, most_skin = 2.0;
enum { OFTEN = 8, SELDOM = 60, LATE_FORCES = 32, FEW = 64 };

/* In one direction, the most that the unit springs of a point's partners add up to, sum of n n^T:
   on a surface (a point on a flat one, two or four around it in a hollow), and from all sides. */
static const double surface_springs[3] = {1.0, 1.5, 2.0}, all_springs[3] = {2.0, 3.0, 4.0};

/* ---- forces ---------------------------------------------------------------------------------- */

static int32_t chunk_end(const sdr_contact *contact, int c)
{
  const int32_t end = (c + 1) * SDR_CONTACT_CHUNK;
  return end < contact->count ? end : contact->count;
}

static double stiffness(const sdr_contact *contact, int32_t a, int32_t b)
{
  return fmin(contact->stiffness[contact->point[a]], contact->stiffness[contact->point[b]]);
}

/* l^2 of a pair and y_b - y_a; both turn sign exactly with the pair. */
static double apart(const sdr_contact *contact, int32_t a, int32_t b, double way[3])
{
  const double *y = contact->place + 3 * (size_t)a, *z = contact->place + 3 * (size_t)b;
  for (int c = 0; c < 3; ++c) way[c] = z[c] - y[c];
  return way[0] * way[0] + way[1] * way[1] + way[2] * way[2];
}

/* Force of spot b on spot a, N, which touch: l < d. */
static void push(const sdr_contact *contact, int32_t a, int32_t b, double d, double square,
                 const double way[3], double force[3])
{
  const double l = sqrt(square);
  const double factor = l > 0.0 ? stiffness(contact, a, b) * (d - l) / l : 0.0;
  for (int c = 0; c < 3; ++c) force[c] -= factor * way[c];
}

typedef struct {
  sdr_contact *contact;
  double *const *f;
} force_call;

/* Rows hold each pair at both ends, so that each spot adds to itself alone. */
static void force_of_chunk(void *context, int c)
{
  const force_call *call = context;
  sdr_contact *contact = call->contact;
  sdr_contact_rows *rows = &contact->chunks[c];
  const int32_t first = c * SDR_CONTACT_CHUNK, end = chunk_end(contact, c);
  rows->closest = 1.0;
  for (int32_t a = first; a < end; ++a) {
    double force[3] = {0.0};
    int touches = 0;
    for (int32_t k = rows->row[a - first]; k < rows->row[a - first + 1]; ++k) {
      double way[3];
      const double d = rows->distance[k], square = apart(contact, a, rows->partner[k], way);
      if (!(square < d * d)) continue;
      touches = 1;
      rows->closest = fmin(rows->closest, square / (d * d));
      push(contact, a, rows->partner[k], d, square, way, force);
    }
    for (int n = 0; touches && n < contact->points->components; ++n)
      call->f[n][contact->point[a]] += force[n];
  }
}

/* ---- pairs lost since the search ------------------------------------------------------------- */

/* Both ends of a pair, if it is near. */
static sdr_status add_late(sdr_contact *contact, int32_t i, int32_t j)
{
  const sdr_points *points = contact->points;
  double way[3];
  if (!sdr_in_body(points, i) || !sdr_in_body(points, j)) return SDR_OK;
  if (contact->spot_of[i] < 0) SDR_TRY(sdr_contact_expose(contact, i));
  if (contact->spot_of[j] < 0) SDR_TRY(sdr_contact_expose(contact, j));
  if (contact->late_count + 2 > contact->late_room) {
    const int32_t room = 2 * contact->late_room + FEW;
    sdr_contact_entry *grown = sdr_realloc(contact->late, (size_t)room, sizeof *grown);
    if (!grown) return SDR_RUN_FAILED;
    contact->late = grown;
    contact->late_room = room;
  }
  const int32_t a = contact->spot_of[i], b = contact->spot_of[j];
  const double d = sdr_contact_reach(contact, i, j, sdr_distance_squared(points, i, j));
  if (!(apart(contact, a, b, way) < (d + contact->skin) * (d + contact->skin))) return SDR_OK;
  contact->late[contact->late_count++] = (sdr_contact_entry){a, b, j, d};
  contact->late[contact->late_count++] = (sdr_contact_entry){b, a, i, d};
  return SDR_OK;
}

static sdr_status take_late(sdr_contact *contact)
{
  SDR_TRY(sdr_lost_check(&contact->lost));
  for (int s = 0; s < SDR_LOST_STRIPES; ++s)
    for (int32_t k = 0; k < contact->lost.stripe[s].count; ++k) {
      const sdr_lost_pair pair = contact->lost.stripe[s].pair[k];
      if (contact->late_at == 0) contact->late_at = contact->since;
      SDR_TRY(add_late(contact, pair.i, pair.j));
    }
  sdr_lost_empty(&contact->lost);
  return sdr_contact_merge(contact);
}

/* Points exposed since the search are the partners of those alone whose bonds they lost; others can
   come near them only past what was exposed before. */
static int is_due(const sdr_contact *contact, double moved)
{
  return 2.0 * moved > contact->skin ||
         (contact->late_at > 0 && contact->since - contact->late_at >= LATE_FORCES);
}

static void choose_skin(sdr_contact *contact, double moved)
{
  const double unit = contact->most_range / contact->range;
  if (!(2.0 * moved > contact->skin)) return;
  if (contact->since < OFTEN) contact->skin = fmin(1.5 * contact->skin, most_skin * unit);
  if (contact->since > SELDOM) contact->skin = fmax(contact->skin / 1.5, least_skin * unit);
}

sdr_status sdr_contact_force(sdr_contact *contact, double *const u[3], double *const f[3])
{
  ++contact->since;
  contact->u = u;
  if (contact->stale) {
    SDR_TRY(sdr_contact_search(contact, u));
  } else {
    const double moved = sdr_contact_follow(contact, u);
    SDR_TRY(take_late(contact));
    if (is_due(contact, moved)) {
      choose_skin(contact, moved);
      SDR_TRY(sdr_contact_search(contact, u));
    }
  }
  force_call call = {contact, f};
  sdr_parallel_for(0, contact->chunk_count, 1, force_of_chunk, &call);
  for (int32_t c = 0; c < contact->chunk_count; ++c)
    contact->closest = fmin(contact->closest, sqrt(contact->chunks[c].closest));
  return SDR_OK;
}

/* ---- energy ---------------------------------------------------------------------------------- */

static double energy_of(const sdr_contact *contact, int32_t a, int32_t b, double d)
{
  double way[3];
  const double square = apart(contact, a, b, way), short_of = d - sqrt(square);
  return square < d * d ? 0.5 * stiffness(contact, a, b) * short_of * short_of : 0.0;
}

/* Over points in their order: spots may have come in another. */
double sdr_contact_energy(const sdr_contact *contact)
{
  double sum = 0.0;
  for (int32_t i = 0; i < contact->points->count; ++i) {
    const int32_t a = contact->spot_of[i], c = a / SDR_CONTACT_CHUNK;
    if (a < 0) continue;
    const sdr_contact_rows *rows = &contact->chunks[c];
    const int32_t *row = rows->row + (a - c * SDR_CONTACT_CHUNK);
    for (int32_t k = row[0]; k < row[1]; ++k)
      sum += energy_of(contact, a, rows->partner[k], rows->distance[k]);
  }
  return 0.5 * sum; /* rows hold each pair twice */
}

void sdr_contact_look(const sdr_contact *contact, sdr_contact_state *out)
{
  int64_t entries = 0, touching = 0;
  for (int32_t c = 0; c < contact->chunk_count; ++c) {
    const sdr_contact_rows *rows = &contact->chunks[c];
    const int32_t first = c * SDR_CONTACT_CHUNK, end = chunk_end(contact, c);
    entries += rows->row[end - first];
    for (int32_t a = first; a < end; ++a)
      for (int32_t k = rows->row[a - first]; k < rows->row[a - first + 1]; ++k)
        touching += energy_of(contact, a, rows->partner[k], rows->distance[k]) > 0.0;
  }
  *out = (sdr_contact_state){.exposed = contact->count,
                             .candidates = entries / 2,
                             .touching = touching / 2,
                             .closest = contact->closest,
                             .searches = contact->searches};
}

sdr_status sdr_contact_restart(sdr_contact *contact, double *const u[3])
{
  contact->skin = first_skin * contact->most_range / contact->range;
  contact->searches = 0;
  return sdr_contact_search(contact, u);
}

/* ---- the stable step ------------------------------------------------------------------------- */

/* Springs between points weigh at most twice what each point has of them by itself. */
void sdr_contact_bound_times(const sdr_contact *contact, double *const v[3], double *const out[3])
{
  const sdr_points *points = contact->points;
  const double springs = 2.0 * surface_springs[points->components - 1];
  for (int a = 0; a < points->components; ++a)
    for (int32_t i = 0; i < points->count; ++i)
      if (contact->surface[i]) out[a][i] += springs * contact->stiffness[i] * v[a][i];
}

double sdr_contact_loose_rate(const sdr_contact *contact, const double *mass)
{
  const sdr_points *points = contact->points;
  const double springs = 2.0 * all_springs[points->components - 1];
  double most = 0.0;
  for (int32_t i = 0; i < points->count; ++i)
    if (sdr_in_body(points, i)) most = fmax(most, springs * contact->stiffness[i] / mass[i]);
  return most;
}

/* ---- creation -------------------------------------------------------------------------------- */

/* Poisson's ratio that the body has, and the modulus of uniaxial strain, Pa. */
static double uniaxial_modulus(const sdr_scene *scene, int material)
{
  static const double own[] = {0.0, 1.0 / 3.0, 0.25, 0.25}; /* of bond-based bodies */
  const double young = scene->material[material].young;
  const double nu =
      scene->model == SDR_BOND_BASED ? own[scene->dimension] : scene->material[material].poisson;
  if (scene->dimension == SDR_1D) return young;
  if (scene->dimension == SDR_PLANE_STRESS) return young / (1.0 - nu * nu);
  return young * (1.0 - nu) / ((1.0 + nu) * (1.0 - 2.0 * nu));
}

static void set_stiffness(sdr_contact *contact, const sdr_scene *scene)
{
  const sdr_points *points = contact->points;
  for (int32_t i = 0; i < points->count; ++i) {
    const double modulus = uniaxial_modulus(scene, points->material[i]);
    contact->stiffness[i] = scene->contact.penalty * modulus * points->volume[i] /
                            (points->spacing[i] * points->spacing[i]);
    contact->most_range = fmax(contact->most_range, contact->range * points->spacing[i]);
  }
}

typedef struct {
  const double *volume;
  double *family;
} family_call;

static void add_volume(void *context, const sdr_pair *pair)
{
  const family_call *call = context;
  if (pair->weight_ij > 0.0) call->family[pair->i] += call->volume[pair->j];
  if (pair->weight_ji > 0.0 && !pair->loose) call->family[pair->j] += call->volume[pair->i];
}

/* A point is at a surface if its family lacks much of its ball: a plane cut beside it takes 0.4. */
static sdr_status find_surface(sdr_contact *contact)
{
  static const double ball[3] = {2.0, 3.14159265358979323846, 4.18879020478639098462};
  const sdr_points *points = contact->points;
  const int n = points->components;
  sdr_model_traits traits;
  family_call call = {points->volume, sdr_alloc(sdr_points_padded(points), sizeof(double))};
  if (!call.family) return SDR_RUN_FAILED;
  contact->model->ops->traits(contact->model, &traits);
  sdr_bonds_visit(traits.bonds, points, add_volume, &call);
  double full = ball[n - 1];
  for (int32_t i = 0; i < points->count; ++i) {
    const double thickness = points->volume[i] / pow(points->spacing[i], n);
    call.family[i] /= thickness * pow(points->horizon[i], n);
    if (!points->irregular && sdr_in_body(points, i)) full = fmax(full, call.family[i]);
  }
  for (int32_t i = 0; i < points->count; ++i) {
    /* where a family has few members, the one beyond the surface is a small share of them */
    const double share = points->horizon[i] < 1.4 * points->spacing[i] ? 0.9 : 0.8;
    contact->surface[i] = sdr_in_body(points, i) && call.family[i] < share * full;
    contact->exposed[i] = contact->surface[i];
  }
  sdr_free(call.family);
  return SDR_OK;
}

sdr_status sdr_contact_create(const sdr_scene *scene, sdr_model *model, sdr_contact **out)
{
  *out = NULL;
  if (!scene->contact.on) return SDR_OK;
  sdr_contact *contact = sdr_alloc(1, sizeof *contact);
  if (!contact) return SDR_RUN_FAILED;
  const size_t padded = sdr_points_padded(model->points);
  contact->model = model;
  contact->points = model->points;
  contact->range = scene->contact.range;
  contact->closest = 1.0;
  contact->stale = 1;
  contact->stiffness = sdr_alloc(padded, sizeof *contact->stiffness);
  contact->exposed = sdr_alloc(padded, 1);
  contact->surface = sdr_alloc(padded, 1);
  contact->spot_of = sdr_alloc(padded, sizeof *contact->spot_of);
  sdr_status status = SDR_RUN_FAILED;
  if (contact->stiffness && contact->exposed && contact->surface && contact->spot_of) {
    for (int32_t i = 0; i < model->points->count; ++i) contact->spot_of[i] = -1;
    set_stiffness(contact, scene);
    contact->skin = first_skin * contact->most_range / contact->range;
    status = find_surface(contact);
  }
  if (status != SDR_OK) {
    sdr_contact_destroy(&contact);
    return status;
  }
  model->lost = &contact->lost;
  *out = contact;
  return SDR_OK;
}

void sdr_contact_destroy(sdr_contact **contact)
{
  sdr_contact *c = *contact;
  if (!c) return;
  if (c->model->lost == &c->lost) c->model->lost = NULL;
  for (int32_t k = 0; k < c->chunk_room; ++k) {
    sdr_free(c->chunks[k].partner);
    sdr_free(c->chunks[k].distance);
  }
  void *const blocks[] = {c->stiffness, c->exposed,  c->surface, c->spot_of, c->point,
                          c->place,     c->searched, c->chunks,  c->late,    c->first,
                          c->member,    c->torn_row, c->torn};
  for (size_t k = 0; k < sizeof blocks / sizeof *blocks; ++k) sdr_free(blocks[k]);
  sdr_lost_clear(&c->lost);
  sdr_lost_clear(&c->near);
  sdr_free(c);
  *contact = NULL;
}
