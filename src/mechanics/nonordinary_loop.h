/* The passes over the pairs of runs, written once; `n` (components), `finite` strain, `sums`,
   `marked`, `sides` are literals where they are inlined (nonordinary_kernels.c).

   Pass A gathers the moments of displacement differences eta; pass A2 (finite strain) what the
   control of the normal part needs, whose direction F xi is known only then; pass B hands out
   forces. A pair's two directed states see xi, eta and -xi, -eta: every product of two of them is
   the same for both. */
#ifndef SDR_MECHANICS_NONORDINARY_LOOP_H
#define SDR_MECHANICS_NONORDINARY_LOOP_H

#include "mechanics/nonordinary_body.h"

#define SDR_INLINE static inline __attribute__((always_inline))

enum { SDR_BLOCK = 256, SDR_SIDE_I = 1, SDR_SIDE_J = 2 };

/* A block of a run's pairs: indices of its first pair. */
typedef struct {
  const sdr_bond_class *class;
  int64_t i, j;
  const sdr_flags *flags; /* of a marked run */
  int count;
} sdr_pairs;

SDR_INLINE sdr_pairs pairs_at(const sdr_nonordinary_body *body, const sdr_bond_run *run,
                              int32_t start)
{
  const int32_t left = run->length - start;
  return (sdr_pairs){&body->bonds->classes[run->class_index], run->i0 + start, run->j0 + start,
                     body->flags ? body->flags + run->slot + start : NULL,
                     left < SDR_BLOCK ? left : SDR_BLOCK};
}

/* Points of i and j overlap: a run along its own row. */
SDR_INLINE int overlaps(const sdr_bond_run *run)
{
  return (run->j0 > run->i0 ? run->j0 - run->i0 : run->i0 - run->j0) < run->length;
}

/* ---- pass A ---------------------------------------------------------------------------------- */

/* Moments of one directed state: those of M, those of Q that are kept, and the two sums. */
typedef struct {
  double *m[9], *q[5], *square, *along;
} sdr_sums;

SDR_INLINE int kept_of_normal(const int n)
{
  return n == 1 ? 0 : n == 2 ? 2 : 5;
}

SDR_INLINE sdr_sums sums_at(const int n, const sdr_nonordinary_body *body, int64_t i)
{
  sdr_sums s = {.square = body->square + i, .along = body->along + i};
  for (int a = 0; a < n * n; ++a) s.m[a] = body->gradient[a] + i;
  for (int a = 0; a < kept_of_normal(n); ++a) s.q[a] = body->bearing[a] + i;
  return s;
}

/* W xi_b for M, W xi_a xi_b/|xi| for Q, W and W for the sums. */
typedef struct {
  double m[3], q[5], w;
} sdr_moments;

SDR_INLINE sdr_moments moments_of(const int n, const double *xi, double length, double w)
{
  sdr_moments f = {.w = w};
  int k = 0;
  for (int a = 0; a < n; ++a) {
    f.m[a] = w * xi[a];
    for (int b = a; b < n; ++b)
      if (k < kept_of_normal(n)) f.q[k++] = w * xi[a] * xi[b] / length;
  }
  return f;
}

SDR_INLINE void gather_block(const int n, const int finite, const int sums, const int marked,
                             const int sides, const sdr_nonordinary_body *body,
                             const sdr_pairs *pairs, double *const u[3])
{
  const sdr_bond_class *class = pairs->class;
  const sdr_sums si = sums_at(n, body, pairs->i), sj = sums_at(n, body, pairs->j);
  const sdr_moments fi = moments_of(n, class->xi, class->length, class->weight_ij);
  const sdr_moments fj = moments_of(n, class->xi, class->length, class->weight_ji);
  const double by_length = 1.0 / class->length;
  const double normal[3] = {class->xi[0] * by_length, class->xi[1] * by_length,
                            class->xi[2] * by_length};
  const double *const xi = u[0] + pairs->i, *const xj = u[0] + pairs->j;
  const double *const yi = n > 1 ? u[1] + pairs->i : xi, *const yj = n > 1 ? u[1] + pairs->j : xj;
  const double *const zi = n > 2 ? u[2] + pairs->i : xi, *const zj = n > 2 ? u[2] + pairs->j : xj;
#pragma omp simd
  for (int k = 0; k < pairs->count; ++k) {
    const double eta[3] = {xj[k] - xi[k], n > 1 ? yj[k] - yi[k] : 0.0, n > 2 ? zj[k] - zi[k] : 0.0};
    double along = 0.0, square = 0.0, left_i = 1.0, left_j = 1.0;
    if (!finite)
      for (int a = 0; a < n; ++a) along += eta[a] * normal[a];
    if (sums)
      for (int a = 0; a < n; ++a) square += eta[a] * eta[a];
    if (marked) {
      left_i = pairs->flags[k] & SDR_LOST_I ? 0.0 : 1.0;
      left_j = pairs->flags[k] & SDR_LOST_J ? 0.0 : 1.0;
    }
    if (sides & SDR_SIDE_I) {
      for (int a = 0; a < n; ++a)
        for (int b = 0; b < n; ++b) si.m[n * a + b][k] += left_i * fi.m[b] * eta[a];
      for (int a = 0; !finite && a < kept_of_normal(n); ++a) si.q[a][k] += left_i * fi.q[a] * along;
      if (sums && !finite) {
        si.square[k] += left_i * fi.w * square;
        si.along[k] += left_i * fi.w * (along * along);
      }
    }
    if (sides & SDR_SIDE_J) {
      for (int a = 0; a < n; ++a)
        for (int b = 0; b < n; ++b) sj.m[n * a + b][k] += left_j * fj.m[b] * eta[a];
      for (int a = 0; !finite && a < kept_of_normal(n); ++a) sj.q[a][k] += left_j * fj.q[a] * along;
      if (sums && !finite) {
        sj.square[k] += left_j * fj.w * square;
        sj.along[k] += left_j * fj.w * (along * along);
      }
    }
  }
}

SDR_INLINE void gather_runs(const int n, const int finite, const int sums,
                            const sdr_nonordinary_body *body, int64_t first, int64_t end,
                            double *const u[3])
{
  for (int64_t r = first; r < end; ++r) {
    const sdr_bond_run *run = &body->bonds->runs[r];
    const int marked = body->run_flagged && body->run_flagged[r], overlap = overlaps(run);
    for (int32_t start = 0; start < run->length; start += SDR_BLOCK) {
      const sdr_pairs pairs = pairs_at(body, run, start);
      if (!marked && !overlap) {
        gather_block(n, finite, sums, 0, SDR_SIDE_I | SDR_SIDE_J, body, &pairs, u);
      } else if (!marked) {
        gather_block(n, finite, sums, 0, SDR_SIDE_I, body, &pairs, u);
        gather_block(n, finite, sums, 0, SDR_SIDE_J, body, &pairs, u);
      } else {
        gather_block(n, finite, sums, 1, SDR_SIDE_I, body, &pairs, u);
        gather_block(n, finite, sums, 1, SDR_SIDE_J, body, &pairs, u);
      }
    }
  }
}

/* ---- pass A2 --------------------------------------------------------------------------------- */

/* p = G xi and f = F xi of a point, z = eta - p, (z.f) and f.f. */
typedef struct {
  double f[3], z[3], along, square;
} sdr_residual;

SDR_INLINE sdr_residual residual_of(const int n, const double *const g[9], int64_t k,
                                    const double *xi, const double *eta)
{
  sdr_residual r = {.along = 0.0};
  r.square = 1e-300;
  for (int a = 0; a < n; ++a) {
    double p = 0.0;
    for (int b = 0; b < n; ++b) p += g[n * a + b][k] * xi[b];
    r.f[a] = xi[a] + p;
    r.z[a] = eta[a] - p;
    r.along += r.z[a] * r.f[a];
    r.square += r.f[a] * r.f[a];
  }
  return r;
}

/* Add to a point's S = sum W h_p (x) xi, with h = (z.f)^2/(2 f.f), p = G xi, and to its sums.
   by_square: 1/(f.f); w: W, 0 for a lost half. */
SDR_INLINE void add_control(const int n, const sdr_residual *r, double by_square, double w,
                            const double *xi, double *const s[9], double *square, double *along,
                            int64_t k)
{
  const double share = r->along * by_square;
  double z = 0.0;
  for (int a = 0; a < n; ++a) {
    const double h = w * share * (r->z[a] - (1.0 + share) * r->f[a]);
    for (int b = 0; b < n; ++b) s[n * a + b][k] += h * xi[b];
    z += r->z[a] * r->z[a];
  }
  square[k] += w * z;
  along[k] += w * share * r->along;
}

/* Gradients and control sums of the points of one side. */
typedef struct {
  const double *g[9];
  double *s[9], *square, *along;
} sdr_side;

SDR_INLINE sdr_side side_at(const int n, const sdr_nonordinary_body *body, int64_t i)
{
  sdr_side side = {.square = body->square + i, .along = body->along + i};
  for (int a = 0; a < n * n; ++a) {
    side.g[a] = body->gradient[a] + i;
    side.s[a] = body->bearing[a] + i;
  }
  return side;
}

SDR_INLINE void control_block(const int n, const int marked, const int sides,
                              const sdr_nonordinary_body *body, const sdr_pairs *pairs,
                              double *const u[3])
{
  const sdr_bond_class *class = pairs->class;
  const sdr_side si = side_at(n, body, pairs->i), sj = side_at(n, body, pairs->j);
  const double xi[3] = {class->xi[0], class->xi[1], class->xi[2]};
  const double wi = class->weight_ij, wj = class->weight_ji;
  const double *ui[3], *uj[3];
  for (int a = 0; a < n; ++a) {
    ui[a] = u[a] + pairs->i;
    uj[a] = u[a] + pairs->j;
  }
#pragma omp simd
  for (int k = 0; k < pairs->count; ++k) {
    double eta[3], left_i = wi, left_j = wj;
    for (int a = 0; a < n; ++a) eta[a] = uj[a][k] - ui[a][k];
    if (marked) {
      left_i = pairs->flags[k] & SDR_LOST_I ? 0.0 : wi;
      left_j = pairs->flags[k] & SDR_LOST_J ? 0.0 : wj;
    }
    if (sides == (SDR_SIDE_I | SDR_SIDE_J)) {
      const sdr_residual ri = residual_of(n, si.g, k, xi, eta);
      const sdr_residual rj = residual_of(n, sj.g, k, xi, eta);
      const double both = 1.0 / (ri.square * rj.square);
      add_control(n, &ri, rj.square * both, left_i, xi, si.s, si.square, si.along, k);
      add_control(n, &rj, ri.square * both, left_j, xi, sj.s, sj.square, sj.along, k);
    } else if (sides == SDR_SIDE_I) {
      const sdr_residual r = residual_of(n, si.g, k, xi, eta);
      add_control(n, &r, 1.0 / r.square, left_i, xi, si.s, si.square, si.along, k);
    } else {
      const sdr_residual r = residual_of(n, sj.g, k, xi, eta);
      add_control(n, &r, 1.0 / r.square, left_j, xi, sj.s, sj.square, sj.along, k);
    }
  }
}

SDR_INLINE void control_runs(const int n, const sdr_nonordinary_body *body, int64_t first,
                             int64_t end, double *const u[3])
{
  for (int64_t r = first; r < end; ++r) {
    const sdr_bond_run *run = &body->bonds->runs[r];
    const int marked = body->run_flagged && body->run_flagged[r], overlap = overlaps(run);
    for (int32_t start = 0; start < run->length; start += SDR_BLOCK) {
      const sdr_pairs pairs = pairs_at(body, run, start);
      if (!marked && !overlap) {
        control_block(n, 0, SDR_SIDE_I | SDR_SIDE_J, body, &pairs, u);
      } else if (!marked) {
        control_block(n, 0, SDR_SIDE_I, body, &pairs, u);
        control_block(n, 0, SDR_SIDE_J, body, &pairs, u);
      } else {
        control_block(n, 1, SDR_SIDE_I, body, &pairs, u);
        control_block(n, 1, SDR_SIDE_J, body, &pairs, u);
      }
    }
  }
}

/* ---- pass B ---------------------------------------------------------------------------------- */

typedef struct {
  const double *g[9], *a[9], *soft, *stiff;
} sdr_bearing;

SDR_INLINE sdr_bearing bearing_at(const int n, const sdr_nonordinary_body *body, int64_t i)
{
  sdr_bearing at = {.soft = body->soft + i, .stiff = body->stiff + i};
  for (int a = 0; a < n * n; ++a) {
    at.g[a] = body->gradient[a] + i;
    at.a[a] = body->bearing[a] + i;
  }
  return at;
}

/* Force per W of the bond's normal part over its direction (normal, or f itself): stiff z.n. */
SDR_INLINE double normal_of_linear(const int n, const sdr_bearing *at, int64_t k, double along,
                                   const double *xi, const double *normal)
{
  double strain = 0.0; /* n.G xi, G symmetric */
  for (int a = 0; a < n; ++a) {
    strain += at->g[n * a + a][k] * (normal[a] * xi[a]);
    for (int b = a + 1; b < n; ++b) strain += at->g[n * a + b][k] * (2.0 * normal[a] * xi[b]);
  }
  return at->stiff[k] * (along - strain);
}

/* Forces on i of the block's pairs; those on j are opposite. */
SDR_INLINE void force_block(const int n, const int finite, const int marked, const int overlap,
                            const sdr_nonordinary_body *body, const sdr_pairs *pairs,
                            double *const u[3], double *const f[3], double F[3][SDR_BLOCK])
{
  const sdr_bond_class *class = pairs->class;
  const sdr_bearing at_i = bearing_at(n, body, pairs->i), at_j = bearing_at(n, body, pairs->j);
  const double wij = class->weight_ij, wji = class->weight_ji, by_length = 1.0 / class->length;
  double xi[3], normal[3];
  const double *ui[3], *uj[3];
  double *fi[3], *fj[3];
  for (int a = 0; a < n; ++a) {
    xi[a] = class->xi[a];
    normal[a] = xi[a] * by_length;
    ui[a] = u[a] + pairs->i;
    uj[a] = u[a] + pairs->j;
    fi[a] = f[a] + pairs->i;
    fj[a] = f[a] + pairs->j;
  }
#pragma omp simd
  for (int k = 0; k < pairs->count; ++k) {
    double eta[3], force[3], wi = wij, wj = wji;
    for (int a = 0; a < n; ++a) eta[a] = uj[a][k] - ui[a][k];
    if (marked) {
      wi = pairs->flags[k] & SDR_LOST_I ? 0.0 : wi;
      wj = pairs->flags[k] & SDR_LOST_J ? 0.0 : wj;
    }
    const double soft = wi * at_i.soft[k] + wj * at_j.soft[k];
    for (int a = 0; a < n; ++a) {
      force[a] = soft * eta[a];
      for (int b = 0; b < n; ++b)
        force[a] += (wi * at_i.a[n * a + b][k] + wj * at_j.a[n * a + b][k]) * xi[b];
    }
    if (finite) {
      const sdr_residual ri = residual_of(n, at_i.g, k, xi, eta);
      const sdr_residual rj = residual_of(n, at_j.g, k, xi, eta);
      const double both = 1.0 / (ri.square * rj.square);
      const double ci = wi * at_i.stiff[k] * (ri.along * (rj.square * both));
      const double cj = wj * at_j.stiff[k] * (rj.along * (ri.square * both));
      for (int a = 0; a < n; ++a) force[a] += ci * ri.f[a] + cj * rj.f[a];
    } else {
      double along = 0.0;
      for (int a = 0; a < n; ++a) along += eta[a] * normal[a];
      const double c = wi * normal_of_linear(n, &at_i, k, along, xi, normal) +
                       wj * normal_of_linear(n, &at_j, k, along, xi, normal);
      for (int a = 0; a < n; ++a) force[a] += c * normal[a];
    }
    for (int a = 0; a < n; ++a) {
      if (overlap) {
        F[a][k] = force[a];
      } else {
        fi[a][k] += force[a];
        fj[a][k] -= force[a];
      }
    }
  }
}

/* i and j sides apart, since a run along its own row overlaps itself. */
SDR_INLINE void add_forces(const int n, const sdr_pairs *pairs, double F[3][SDR_BLOCK],
                           double *const f[3])
{
  for (int a = 0; a < n; ++a) {
    double *const fi = f[a] + pairs->i, *const fj = f[a] + pairs->j;
    const double *const force = F[a];
#pragma omp simd
    for (int k = 0; k < pairs->count; ++k) fi[k] += force[k];
#pragma omp simd
    for (int k = 0; k < pairs->count; ++k) fj[k] -= force[k];
  }
}

SDR_INLINE void force_runs(const int n, const int finite, const sdr_nonordinary_body *body,
                           int64_t first, int64_t end, double *const u[3], double *const f[3])
{
  _Alignas(64) double F[3][SDR_BLOCK];
  for (int64_t r = first; r < end; ++r) {
    const sdr_bond_run *run = &body->bonds->runs[r];
    const int marked = body->run_flagged && body->run_flagged[r], overlap = overlaps(run);
    for (int32_t start = 0; start < run->length; start += SDR_BLOCK) {
      const sdr_pairs pairs = pairs_at(body, run, start);
      if (marked)
        force_block(n, finite, 1, 1, body, &pairs, u, f, F);
      else if (overlap)
        force_block(n, finite, 0, 1, body, &pairs, u, f, F);
      else
        force_block(n, finite, 0, 0, body, &pairs, u, f, F);
      if (marked || overlap) add_forces(n, &pairs, F, f);
    }
  }
}

/* ---- bonds that break ------------------------------------------------------------------------ */

SDR_INLINE int found_in_block(const int n, const int marked, const sdr_pairs *pairs,
                              const double *limit, double *const u[3])
{
  const sdr_bond_class *class = pairs->class;
  const double *const limit_i = limit + pairs->i, *const limit_j = limit + pairs->j;
  const double *ui[3], *uj[3], xi[3] = {class->xi[0], class->xi[1], class->xi[2]};
  for (int a = 0; a < n; ++a) {
    ui[a] = u[a] + pairs->i;
    uj[a] = u[a] + pairs->j;
  }
  int any = 0;
#pragma omp simd reduction(| : any)
  for (int k = 0; k < pairs->count; ++k) {
    double z = 0.0;
    for (int a = 0; a < n; ++a) {
      const double eta = uj[a][k] - ui[a][k];
      z += (2.0 * xi[a] + eta) * eta;
    }
    z *= class->inverse_square;
    int over_i = z > limit_i[k], over_j = z > limit_j[k];
    if (marked) {
      over_i = pairs->flags[k] & (SDR_LOST_I | SDR_PROTECTED) ? 0 : over_i;
      over_j = pairs->flags[k] & (SDR_LOST_J | SDR_PROTECTED) ? 0 : over_j;
    }
    any |= over_i | over_j;
  }
  return any;
}

SDR_INLINE void find_runs(const int n, const sdr_nonordinary_body *body, int64_t first, int64_t end,
                          double *const u[3], const double *limit, uint8_t *found)
{
  for (int64_t r = first; r < end; ++r) {
    const sdr_bond_run *run = &body->bonds->runs[r];
    int any = 0;
    for (int32_t start = 0; start < run->length; start += SDR_BLOCK) {
      const sdr_pairs pairs = pairs_at(body, run, start);
      any |= body->run_flagged && body->run_flagged[r] ? found_in_block(n, 1, &pairs, limit, u)
                                                       : found_in_block(n, 0, &pairs, limit, u);
    }
    found[r] = (uint8_t)any;
  }
}

#endif
