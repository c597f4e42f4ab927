/* The passes over pairs, written once; `n` (components), `finite` strain, `sums` are literals where
   they are inlined (nonordinary_kernels.c).

   Points are lanes (lanes.h). What a point gathers over its family stays in registers until its
   force states are known, and those of runs are handed out at once, to itself and to the family:
   nothing is stored between the passes. Runs come as bundles, whose constants are those of their
   class; loose pairs in columns with constants a lane. Each loose pair is looked at from both ends,
   when all states are known.

   Pass A gathers the moments of displacement differences eta; pass A2 (finite strain) what the
   control of the normal part needs, whose direction F xi is known only then; pass B sums forces. */
#ifndef SDR_MECHANICS_NONORDINARY_LOOP_H
#define SDR_MECHANICS_NONORDINARY_LOOP_H

#include "mechanics/lanes.h"
#include "mechanics/nonordinary_body.h"
#include "mechanics/records.h"

/* Sums of pass A: M = sum W eta (x) xi, Q = sum W (eta.n) n (x) xi (upper half without its last
   value, which the trace of M gives), sum W |eta|^2 and sum W (eta.n)^2. Of pass A2: S, and the
   last two of z. */
typedef struct {
  sdr_lanes m[9], q[5], s[9], square, along;
} sdr_lanes_sums;

/* Points i to i + SDR_WIDTH - 1: lanes from `lane` on of block i/8. */
typedef struct {
  const sdr_nonordinary_body *body;
  double *const *u;
  int64_t i;
  int lane;
} sdr_lanes_points;

/* DO(a, b) for a matrix, DO(k) for the values of Q or a vector, spelt out: sums with known indices
   stay in registers. */
#define SDR_NINE(DO)                                                                               \
  DO(0, 0) DO(0, 1) DO(0, 2) DO(1, 0) DO(1, 1) DO(1, 2) DO(2, 0) DO(2, 1) DO(2, 2)
#define SDR_FIVE(DO) DO(0) DO(1) DO(2) DO(3) DO(4)
#define SDR_THREE(DO) DO(0) DO(1) DO(2)

SDR_INLINE void copy_matrix(const int n, const sdr_lanes *from, sdr_lanes *to)
{
#define SDR_DO(a, b)                                                                               \
  if ((a) < n && (b) < n) to[n * (a) + (b)] = from[n * (a) + (b)];
  SDR_NINE(SDR_DO)
#undef SDR_DO
}

SDR_INLINE void clear_matrix(const int n, sdr_lanes *to)
{
#define SDR_DO(a, b)                                                                               \
  if ((a) < n && (b) < n) to[n * (a) + (b)] = all_lanes(0.0);
  SDR_NINE(SDR_DO)
#undef SDR_DO
}

/* Of the upper half of Q so many values are kept. */
SDR_INLINE int kept_of_normal(const int n)
{
  return n == 1 ? 0 : n == 2 ? 2 : 5;
}

SDR_INLINE void load_all(const int count, double *const from[9], int64_t i, sdr_lanes *to)
{
  for (int k = 0; k < count; ++k) to[k] = load_lanes(from[k] + i);
}

/* ---- bundles --------------------------------------------------------------------------------- */

/* Lanes of a bundle whose half, of the point's own family, is not lost. */
SDR_INLINE unsigned lanes_left(const sdr_lanes_points *at, const sdr_bundle *bundle, unsigned lanes)
{
  const sdr_nonordinary_body *body = at->body;
  if (!body->run_flagged || !body->run_flagged[bundle->run]) return lanes;
  const sdr_bond_run *run = &body->bonds->runs[bundle->run];
  const int side = bundle->direction & 1;
  const sdr_flags lost = side ? SDR_LOST_J : SDR_LOST_I;
  const int64_t slot = run->slot + at->i - (side ? run->j0 : run->i0);
  unsigned left = lanes;
  for (int l = 0; l < SDR_WIDTH; ++l)
    if (lanes >> l & 1u && body->flags[slot + l] & lost) left &= ~(1u << l);
  return left;
}

/* DO(bundle, direction, lanes) for the bundles of the lanes. */
#define SDR_ALL_BUNDLES(DO)                                                                        \
  const sdr_block_bundles *const block = &body->blocks[at->i / SDR_LANES];                         \
  const sdr_bundle *const first_bundle = body->bundles + block->first;                             \
  for (const sdr_bundle *b = first_bundle; b < first_bundle + block->count; ++b) {                 \
    const unsigned lanes = (unsigned)b->lanes >> at->lane & SDR_ALL_LANES;                         \
    if (lanes) DO(b, &body->directions[b->direction], lanes)                                       \
  }

/* ---- loose columns --------------------------------------------------------------------------- */

/* xi, eta and the weights of a column's pairs; a lost half weighs nothing. */
typedef struct {
  const int32_t *j;
  sdr_lanes xi[3], eta[3], by_square, wi, wj;
} sdr_loose_lanes;

/* `other`: displacements of the neighbours. */
SDR_INLINE void loose_lanes_of(const int n, const sdr_nonordinary_body *body, int64_t i,
                               int64_t slot, double *const u[3], const sdr_lanes *other,
                               sdr_loose_lanes *to)
{
  const sdr_loose *loose = &body->bonds->loose;
  sdr_lanes square = all_lanes(0.0);
  to->j = loose->j + slot;
  /* Padding is its own neighbour; to compare whole numbers two by two costs more than to load. */
  if (SDR_WIDTH > 2 && loose->shared_weight != 0.0) {
    const sdr_lanes_int alone = load_ints(to->j) == load_ints(loose->point + i);
    to->wi = to->wj =
        where_set(bits_of_ints(alone), all_lanes(0.0), all_lanes(loose->shared_weight));
  } else {
    to->wi = load_lanes(loose->weight_ij + slot);
    to->wj = load_lanes(loose->weight_ji + slot);
  }
  for (int a = 0; a < n; ++a) {
    to->xi[a] = load_lanes(loose->xi[a] + slot);
    to->eta[a] = other[a] - load_lanes(u[a] + i);
    square = fma_lanes(to->xi[a], to->xi[a], square);
  }
  to->by_square = all_lanes(1.0) / square;
  if (!body->loose_flagged) return;
  const sdr_lanes_int flags = load_ints(body->loose_flags + slot);
  if (!any_ints(flags)) return;
  const sdr_lanes zero = all_lanes(0.0);
  to->wi = where_set(bits_of_ints((flags & SDR_LOST_I) != 0), zero, to->wi);
  to->wj = where_set(bits_of_ints((flags & SDR_LOST_J) != 0), zero, to->wj);
}

SDR_INLINE void loose_lanes(const int n, const sdr_nonordinary_body *body, int64_t i, int64_t slot,
                            double *const u[3], sdr_loose_lanes *to)
{
  sdr_lanes other[SDR_RECORD];
  record_lanes(body->places, SDR_RECORD, body->bonds->loose.j + slot, other);
  loose_lanes_of(n, body, i, slot, u, other, to);
}

/* DO(slot) for the columns of the lanes' block. */
#define SDR_ALL_COLUMNS(DO)                                                                        \
  if (body->bonds->loose.chunk_count > 0) {                                                        \
    const int64_t *const column = body->bonds->loose.chunk_slot + at->i / SDR_LANES;               \
    for (int64_t slot = column[0] + at->lane; slot < column[1]; slot += SDR_LANES) DO(slot)        \
  }

/* ---- pass A ---------------------------------------------------------------------------------- */

/* Of the pairs in the lanes: eta, xi, W xi, W xi (x) xi/xi^2 (kept values), W, W/xi^2. */
typedef struct {
  sdr_lanes eta[3], xi[3], weighted[3], normal[6], w, w_along;
} sdr_lanes_pairs;

SDR_INLINE void add_moments(const int n, const int finite, const int sums, const sdr_lanes_pairs *p,
                            sdr_lanes_sums *to)
{
#define SDR_DO(a, b)                                                                               \
  if ((a) < n && (b) < n)                                                                          \
    to->m[n * (a) + (b)] = fma_lanes(p->weighted[b], p->eta[a], to->m[n * (a) + (b)]);
  SDR_NINE(SDR_DO)
#undef SDR_DO
  if (finite) return;
  sdr_lanes along = p->eta[0] * p->xi[0];
  for (int a = 1; a < n; ++a) along = fma_lanes(p->eta[a], p->xi[a], along);
#define SDR_DO(k)                                                                                  \
  if ((k) < kept_of_normal(n)) to->q[k] = fma_lanes(along, p->normal[k], to->q[k]);
  SDR_FIVE(SDR_DO)
#undef SDR_DO
  if (!sums) return;
  sdr_lanes square = p->eta[0] * p->eta[0];
  for (int a = 1; a < n; ++a) square = fma_lanes(p->eta[a], p->eta[a], square);
  to->square = fma_lanes(p->w, square, to->square);
  to->along = fma_lanes(p->w_along, along * along, to->along);
}

SDR_INLINE void gather_bundle(const int n, const int finite, const int sums,
                              const sdr_lanes_points *at, const sdr_lanes *own, const sdr_bundle *b,
                              const sdr_direction *d, unsigned lanes, sdr_lanes_sums *to)
{
  const unsigned left = lanes_left(at, b, lanes);
  sdr_lanes_pairs p;
  for (int a = 0; a < n; ++a) {
    p.eta[a] = subtract_some(left, load_some(at->u[a] + at->i + b->offset, left), own[a]);
    p.xi[a] = all_lanes(d->xi[a]);
    p.weighted[a] = all_lanes(d->own_xi[a]);
  }
  for (int k = 0; k < kept_of_normal(n); ++k) p.normal[k] = all_lanes(d->own_normal[k]);
  p.w = all_lanes(d->own);
  p.w_along = all_lanes(d->own * d->by_square);
  add_moments(n, finite, sums, &p, to);
}

SDR_INLINE void gather_column(const int n, const int finite, const int sums,
                              const sdr_lanes_points *at, int64_t slot, sdr_lanes_sums *to)
{
  sdr_loose_lanes loose;
  sdr_lanes_pairs p;
  int k = 0;
  loose_lanes(n, at->body, at->i, slot, at->u, &loose);
  p.w = loose.wi;
  p.w_along = loose.wi * loose.by_square;
  for (int a = 0; a < n; ++a) {
    p.eta[a] = loose.eta[a];
    p.xi[a] = loose.xi[a];
    p.weighted[a] = loose.wi * loose.xi[a];
  }
  for (int a = 0; a < n; ++a)
    for (int b = a; b < n; ++b) p.normal[k++] = p.w_along * loose.xi[a] * loose.xi[b];
  add_moments(n, finite, sums, &p, to);
}

SDR_INLINE void gather(const int n, const int finite, const int sums, const sdr_lanes_points *at,
                       sdr_lanes_sums *out)
{
  const sdr_nonordinary_body *body = at->body;
  sdr_lanes own[3];
  sdr_lanes_sums to;
  clear_matrix(n, to.m);
#define SDR_DO(k) to.q[k] = all_lanes(0.0);
  SDR_FIVE(SDR_DO)
#undef SDR_DO
  to.square = to.along = all_lanes(0.0);
  for (int a = 0; a < n; ++a) own[a] = load_lanes(at->u[a] + at->i);
#define SDR_DO(b, d, lanes) gather_bundle(n, finite, sums, at, own, b, d, lanes, &to);
  SDR_ALL_BUNDLES(SDR_DO)
#undef SDR_DO
#define SDR_DO(slot) gather_column(n, finite, sums, at, slot, &to);
  SDR_ALL_COLUMNS(SDR_DO)
#undef SDR_DO
  copy_matrix(n, to.m, out->m);
#define SDR_DO(k)                                                                                  \
  if ((k) < kept_of_normal(n)) out->q[k] = to.q[k];
  SDR_FIVE(SDR_DO)
#undef SDR_DO
  out->square = to.square;
  out->along = to.along;
}

/* ---- pass A2 --------------------------------------------------------------------------------- */

/* p = G xi and f = F xi of a point, z = eta - p, (z.f) and f.f. */
typedef struct {
  sdr_lanes f[3], z[3], along, square;
} sdr_residual;

SDR_INLINE void residual_of(const int n, const sdr_lanes *g, const sdr_lanes *xi,
                            const sdr_lanes *eta, sdr_residual *r)
{
  r->along = all_lanes(0.0);
  r->square = all_lanes(1e-300);
  for (int a = 0; a < n; ++a) {
    sdr_lanes p = g[n * a] * xi[0];
    for (int b = 1; b < n; ++b) p = fma_lanes(g[n * a + b], xi[b], p);
    r->f[a] = xi[a] + p;
    r->z[a] = eta[a] - p;
    r->along = fma_lanes(r->z[a], r->f[a], r->along);
    r->square = fma_lanes(r->f[a], r->f[a], r->square);
  }
}

/* Add to S = sum W h_p (x) xi, with h = (z.f)^2/(2 f.f), p = G xi, and to the sums of z. */
SDR_INLINE void add_control(const int n, const int sums, const sdr_lanes *g, const sdr_lanes *xi,
                            const sdr_lanes *eta, sdr_lanes w, sdr_lanes_sums *to)
{
  sdr_residual r;
  residual_of(n, g, xi, eta, &r);
  const sdr_lanes share = r.along / r.square, part = w * share;
  const sdr_lanes whole = all_lanes(1.0) + share;
  sdr_lanes z = all_lanes(0.0), h[3];
  for (int a = 0; a < n; ++a) {
    h[a] = part * fma_lanes(-whole, r.f[a], r.z[a]);
    z = fma_lanes(r.z[a], r.z[a], z);
  }
#define SDR_DO(a, b)                                                                               \
  if ((a) < n && (b) < n) to->s[n * (a) + (b)] = fma_lanes(h[a], xi[b], to->s[n * (a) + (b)]);
  SDR_NINE(SDR_DO)
#undef SDR_DO
  if (!sums) return;
  to->square = fma_lanes(w, z, to->square);
  to->along = fma_lanes(part, r.along, to->along);
}

SDR_INLINE void control_bundle(const int n, const int sums, const sdr_lanes_points *at,
                               const sdr_lanes *g, const sdr_bundle *b, const sdr_direction *d,
                               unsigned lanes, sdr_lanes_sums *to)
{
  const unsigned left = lanes_left(at, b, lanes);
  sdr_lanes eta[3], xi[3];
  for (int a = 0; a < n; ++a) {
    const double *const u = at->u[a] + at->i;
    eta[a] = load_some(u + b->offset, left) - load_lanes(u);
    xi[a] = all_lanes(d->xi[a]);
  }
  add_control(n, sums, g, xi, eta, only_lanes(left, all_lanes(d->own)), to);
}

/* Pass A2 for G. */
SDR_INLINE void control(const int n, const int sums, const sdr_lanes_points *at, const sdr_lanes *g,
                        sdr_lanes_sums *out)
{
  const sdr_nonordinary_body *body = at->body;
  sdr_lanes_sums to;
  clear_matrix(n, to.s);
  to.square = to.along = all_lanes(0.0);
#define SDR_DO(b, d, lanes) control_bundle(n, sums, at, g, b, d, lanes, &to);
  SDR_ALL_BUNDLES(SDR_DO)
#undef SDR_DO
#define SDR_DO(slot)                                                                               \
  {                                                                                                \
    sdr_loose_lanes p;                                                                             \
    loose_lanes(n, body, at->i, slot, at->u, &p);                                                  \
    add_control(n, sums, g, p.xi, p.eta, p.wi, &to);                                               \
  }
  SDR_ALL_COLUMNS(SDR_DO)
#undef SDR_DO
  copy_matrix(n, to.s, out->s);
  out->square = to.square;
  out->along = to.along;
}

/* ---- pass B ---------------------------------------------------------------------------------- */

/* What bears on the bonds of points: A, G (linear: stiff sym G, upper half), control. */
typedef struct {
  sdr_lanes a[9], g[9], soft, stiff;
} sdr_bearing;

/* What a pair has of its two ends together, each times its weight. */
typedef struct {
  sdr_lanes a[9], g[6], soft, stiff;
} sdr_bearing_sum;

/* Values of G in use: all, or the upper half. */
SDR_INLINE int gradient_entries(const int n, const int finite, int entry[9])
{
  int count = 0;
  for (int a = 0; a < n; ++a)
    for (int b = finite ? 0 : a; b < n; ++b) entry[count++] = n * a + b;
  return count;
}

/* force += A xi + soft eta + (linear) (stiff eta.xi - stiff G:xi (x) xi) xi/xi^2. */
SDR_INLINE void add_linear_force(const int n, const int finite, const sdr_bearing_sum *sum,
                                 const sdr_loose_lanes *p, sdr_lanes *force)
{
  for (int a = 0; a < n; ++a) {
    force[a] = fma_lanes(sum->soft, p->eta[a], force[a]);
    for (int b = 0; b < n; ++b) force[a] = fma_lanes(sum->a[n * a + b], p->xi[b], force[a]);
  }
  if (finite) return;
  sdr_lanes along = all_lanes(0.0), strain = along;
  int k = 0;
  for (int a = 0; a < n; ++a) {
    along = fma_lanes(p->eta[a], p->xi[a], along);
    for (int b = a; b < n; ++b)
      strain = fma_lanes(sum->g[k++], (a == b ? 1.0 : 2.0) * p->xi[a] * p->xi[b], strain);
  }
  const sdr_lanes c = p->by_square * fma_lanes(sum->stiff, along, -strain);
  for (int a = 0; a < n; ++a) force[a] = fma_lanes(c, p->xi[a], force[a]);
}

/* force += the normal control of both ends; ci, cj: W stiff. */
SDR_INLINE void add_normal_force(const int n, const sdr_lanes *gi, const sdr_lanes *gj,
                                 const sdr_lanes *xi, const sdr_lanes *eta, sdr_lanes ci,
                                 sdr_lanes cj, sdr_lanes *force)
{
  sdr_residual i, j;
  residual_of(n, gi, xi, eta, &i);
  residual_of(n, gj, xi, eta, &j);
  const sdr_lanes both = all_lanes(1.0) / (i.square * j.square);
  const sdr_lanes si = ci * (i.along * (j.square * both));
  const sdr_lanes sj = cj * (j.along * (i.square * both));
  for (int a = 0; a < n; ++a) force[a] = fma_lanes(si, i.f[a], fma_lanes(sj, j.f[a], force[a]));
}

/* The force states of a bundle's bonds: added to `force`, taken from f where they lead to. */
SDR_INLINE void spread_bundle(const int n, const int finite, const sdr_lanes_points *at,
                              const sdr_bearing *own, const sdr_bundle *b, const sdr_direction *d,
                              unsigned lanes, sdr_lanes *force, double *const f[3])
{
  const unsigned left = lanes_left(at, b, lanes);
  const int64_t other = at->i + b->offset;
  const sdr_lanes soft = all_lanes(d->own) * own->soft;
  sdr_lanes eta[3], xi[3], t[3];
  for (int a = 0; a < n; ++a) {
    eta[a] = load_some(at->u[a] + other, left) - load_lanes(at->u[a] + at->i);
    xi[a] = all_lanes(d->xi[a]);
  }
  for (int a = 0; a < n; ++a) {
    t[a] = soft * eta[a];
    for (int c = 0; c < n; ++c) t[a] = fma_lanes(own->a[n * a + c], all_lanes(d->own_xi[c]), t[a]);
  }
  if (finite) {
    sdr_residual r;
    residual_of(n, own->g, xi, eta, &r);
    const sdr_lanes c = all_lanes(d->own) * own->stiff * (r.along / r.square);
    for (int a = 0; a < n; ++a) t[a] = fma_lanes(c, r.f[a], t[a]);
  } else {
    sdr_lanes along = eta[0] * xi[0], strain = all_lanes(0.0);
    int k = 0;
    for (int a = 1; a < n; ++a) along = fma_lanes(eta[a], xi[a], along);
    for (int a = 0; a < n; ++a)
      for (int c = a; c < n; ++c)
        strain = fma_lanes(own->g[n * a + c], all_lanes(d->twice[k++]), strain);
    const sdr_lanes c = fma_lanes(own->stiff, along, -strain);
    for (int a = 0; a < n; ++a) t[a] = fma_lanes(c, all_lanes(d->along_xi[a]), t[a]);
  }
#define SDR_DO(a)                                                                                  \
  if ((a) < n) force[a] = add_some(left, force[a], t[a]);
  SDR_THREE(SDR_DO)
#undef SDR_DO
  for (int a = 0; a < n; ++a) {
    double *const to = f[a] + other;
    store_some(to, left, load_some(to, left) - t[a]);
  }
}

/* Forces of all bonds on runs of the points' own families, on both ends. */
SDR_INLINE void spread(const int n, const int finite, const sdr_lanes_points *at,
                       const sdr_bearing *bearing, double *const f[3])
{
  const sdr_nonordinary_body *const body = at->body;
  sdr_bearing own;
  copy_matrix(n, bearing->a, own.a);
  copy_matrix(n, bearing->g, own.g);
  own.soft = bearing->soft;
  own.stiff = bearing->stiff;
  sdr_lanes force[3] = {all_lanes(0.0), all_lanes(0.0), all_lanes(0.0)};
#define SDR_DO(b, d, lanes) spread_bundle(n, finite, at, &own, b, d, lanes, force, f);
  SDR_ALL_BUNDLES(SDR_DO)
#undef SDR_DO
  for (int a = 0; a < n; ++a) store_lanes(f[a] + at->i, load_lanes(f[a] + at->i) + force[a]);
}

/* Numbers of a record of bearings, in its order. */
SDR_INLINE void bearing_lanes(const int n, const int finite, const sdr_nonordinary_body *body,
                              const int32_t *j, sdr_lanes out[24])
{
  const int size = sdr_bearing_size(n, finite);
  for (int k = 0; k < size; k += SDR_RECORD) record_lanes(body->bearings + k, size, j, out + k);
}

SDR_INLINE void force_of_column(const int n, const int finite, const sdr_lanes_points *at,
                                const sdr_lanes *own, int64_t slot, sdr_lanes *force)
{
  const sdr_nonordinary_body *const body = at->body;
  const int soft = n, stiff = n + 1, first_a = n + 2, first_g = n + 2 + n * n;
  const int entries = finite ? n * n : n * (n + 1) / 2;
  sdr_loose_lanes p;
  sdr_lanes other[24];
  sdr_bearing_sum sum;
  bearing_lanes(n, finite, body, body->bonds->loose.j + slot, other);
  loose_lanes_of(n, body, at->i, slot, at->u, other, &p);
  for (int e = 0; e < n * n; ++e)
    sum.a[e] = fma_lanes(p.wi, own[first_a + e], p.wj * other[first_a + e]);
  for (int e = 0; !finite && e < entries; ++e)
    sum.g[e] = fma_lanes(p.wi, own[first_g + e], p.wj * other[first_g + e]);
  const sdr_lanes ci = p.wi * own[stiff], cj = p.wj * other[stiff];
  sum.soft = fma_lanes(p.wi, own[soft], p.wj * other[soft]);
  sum.stiff = ci + cj;
  add_linear_force(n, finite, &sum, &p, force);
  if (finite) add_normal_force(n, own + first_g, other + first_g, p.xi, p.eta, ci, cj, force);
}

/* Forces of loose pairs, by what both ends bear. */
SDR_INLINE void force_of_lanes(const int n, const int finite, const sdr_lanes_points *at,
                               double *const f[3])
{
  const sdr_nonordinary_body *const body = at->body;
  sdr_lanes own[24];
  sdr_lanes force[3] = {all_lanes(0.0), all_lanes(0.0), all_lanes(0.0)};
  bearing_lanes(n, finite, body, body->bonds->loose.point + at->i, own); /* in order */
#define SDR_DO(slot) force_of_column(n, finite, at, own, slot, force);
  SDR_ALL_COLUMNS(SDR_DO)
#undef SDR_DO
  for (int a = 0; a < n; ++a) store_lanes(f[a] + at->i, load_lanes(f[a] + at->i) + force[a]);
}

#endif
