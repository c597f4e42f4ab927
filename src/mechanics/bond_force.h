/* Forces of runs in one kind of number, from bond_loop.h: SDR_REAL double or float, SDR_NAMED(x)
   its names. In float displacements come as sums of two floats in units of the spacing (body->high,
   body->low), so that their differences keep seven digits, and forces are in units of
   body->force_unit; the sums over bonds stay double. */

/* Kinematics of a pair without cancellation (theory sec. 2): z = (2 xi.eta + eta^2)/xi^2,
   r = sqrt(1 + z) = l/|xi|, stretch s = z/(1 + r), force factor z/(r (1 + r)) = s/r. */
typedef struct {
  SDR_REAL s, r;
} SDR_NAMED(sdr_stretch);

/* s without a division: r - 1 has lost digits where s is small; s^2 + 2 s = z gives them back by
   half a Newton step, which is exact there and does nothing elsewhere. */
SDR_INLINE SDR_NAMED(sdr_stretch) SDR_NAMED(stretch_of)(SDR_REAL z)
{
  const SDR_REAL one = (SDR_REAL)1, half = (SDR_REAL)0.5, square = one + z;
  /* l = 0: no direction, no force */
  const SDR_REAL r = SDR_SQRT(square > SDR_SMALLEST ? square : SDR_SMALLEST);
  const SDR_REAL rough = r - one;
  return (SDR_NAMED(sdr_stretch)){rough + half * (z - rough * (rough + (SDR_REAL)2)), r};
}

SDR_INLINE SDR_REAL SDR_NAMED(force_factor)(SDR_REAL z, SDR_REAL r)
{
  return z / (r * ((SDR_REAL)1 + r));
}

/* Stiffness that a pair has left: `soft` under tension, `whole` else. */
SDR_INLINE SDR_REAL SDR_NAMED(stiffness_left)(const int marked, SDR_REAL z, float k, SDR_REAL soft,
                                              SDR_REAL whole)
{
  const SDR_REAL zero = (SDR_REAL)0;
  SDR_REAL left = z > zero ? soft : whole;
  if (marked) {
    left = k == SDR_STRETCH_PROTECTED ? whole : left;
    left = k == SDR_STRETCH_CUT ? zero : left;
  }
  return left;
}

/* Stiffness times force factor of a pair of the variational law: the divisions by r (1 + r), by
   k^2 + q_i and by k^2 + q_j are one. */
SDR_INLINE SDR_REAL SDR_NAMED(variational_factor)(const int each, const int marked, SDR_REAL z,
                                                  SDR_REAL r, float k, SDR_REAL ci, SDR_REAL qi,
                                                  SDR_REAL cj, SDR_REAL qj)
{
  const SDR_REAL kk = (SDR_REAL)k * (SDR_REAL)k, one = (SDR_REAL)1;
  const SDR_REAL a = kk + qi, b = each ? kk + qj : one, ab = a * b, rr = r * (one + r);
  const SDR_REAL all = one / (rr * ab), by_r = ab * all, by_ab = rr * all;
  const SDR_REAL intact_i = qi * b * by_ab, intact_j = each ? qj * a * by_ab : intact_i;
  const SDR_REAL soft = ci * (intact_i * intact_i) + cj * (intact_j * intact_j);
  return SDR_NAMED(stiffness_left)(marked, z, k, soft, ci + cj) * (z * by_r);
}

/* The history that a stretch leaves behind. */
SDR_INLINE float SDR_NAMED(grown_stretch)(const int marked, float before, SDR_REAL s)
{
  const float now = (float)s;
  const float grown = before > now ? before : now;
  if (marked) return before < 0.0f ? before : grown;
  return grown;
}

/* Lost halves after the stretch s, fresh ones marked. */
SDR_INLINE sdr_flags SDR_NAMED(grown_flags)(const int marked, sdr_flags before, SDR_REAL s,
                                            SDR_REAL qi, SDR_REAL qj)
{
  const SDR_REAL zero = (SDR_REAL)0, square = s * s;
  const sdr_flags broken =
      (s > zero && square > qi ? SDR_LOST_I : 0) | (s > zero && square > qj ? SDR_LOST_J : 0);
  const sdr_flags fresh = broken & ~before;
  const sdr_flags grown = before | fresh | fresh << 2;
  if (marked) return before & SDR_PROTECTED ? before : grown;
  return grown;
}

/* What the pairs of a class share, in the kernel's units. */
typedef struct {
  SDR_REAL xi[3], inverse_square, wij, wji; /* weights over length */
} SDR_NAMED(sdr_terms);

SDR_INLINE SDR_NAMED(sdr_terms)
    SDR_NAMED(terms_of)(const sdr_bond_body *body, const sdr_bond_class *class)
{
  const double unit = SDR_LENGTH_UNIT(body), per_unit = SDR_PER_LENGTH_UNIT(body);
  const double stiff = SDR_STIFFNESS_UNIT(body);
  return (SDR_NAMED(sdr_terms)){{(SDR_REAL)(class->xi[0] * per_unit),
                                 (SDR_REAL)(class->xi[1] * per_unit),
                                 (SDR_REAL)(class->xi[2] * per_unit)},
                                (SDR_REAL)(unit * unit * class->inverse_square),
                                (SDR_REAL)(class->by_length_ij * stiff),
                                (SDR_REAL)(class->by_length_ji * stiff)};
}

/* Forces of a block, onto f at once or, where i and j points overlap (a run along its own row) or
   float forces wait to be widened, into F, component-major; returns 1 if a bond was lost in it. */
SDR_INLINE int SDR_NAMED(block_force)(const int components, const int law, const int each,
                                      const int marked, const int commit, const int overlap,
                                      const sdr_bond_body *body, const sdr_block *block,
                                      SDR_REAL F[3][SDR_BLOCK])
{
  const SDR_NAMED(sdr_terms) of = SDR_NAMED(terms_of)(body, block->class);
  const SDR_REAL xx = of.xi[0], xy = of.xi[1], xz = of.xi[2];
  const SDR_REAL two = (SDR_REAL)2, zero = (SDR_REAL)0;
  const SDR_REAL c = (SDR_REAL)SDR_SHARED_STIFFNESS(body), q = (SDR_REAL)body->threshold;
  const double force_unit = SDR_FORCE_UNIT(body);
  sdr_flags fresh = 0;
#pragma omp simd reduction(| : fresh)
  for (int k = 0; k < block->count; ++k) {
    const SDR_REAL ex = SDR_DIFFERENCE(0);
    const SDR_REAL ey = components > 1 ? SDR_DIFFERENCE(1) : zero;
    const SDR_REAL ez = components > 2 ? SDR_DIFFERENCE(2) : zero;
    SDR_REAL z = (two * xx + ex) * ex;
    if (components > 1) z += (two * xy + ey) * ey;
    if (components > 2) z += (two * xz + ez) * ez;
    z *= of.inverse_square;
    const SDR_NAMED(sdr_stretch) t = SDR_NAMED(stretch_of)(z);
    const SDR_REAL ci = of.wij * (each ? block->SDR_NAMED(ci)[k] : c);
    const SDR_REAL cj = of.wji * (each ? block->SDR_NAMED(cj)[k] : c);
    const SDR_REAL qi = each ? block->SDR_NAMED(qi)[k] : q;
    const SDR_REAL qj = each ? block->SDR_NAMED(qj)[k] : q;
    SDR_REAL phi = zero;
    if (law == SDR_LAW_VARIATIONAL) {
      const float grown = SDR_NAMED(grown_stretch)(marked, block->stretch[k], t.s);
      if (commit) block->stretch[k] = grown;
      phi = SDR_NAMED(variational_factor)(each, marked, z, t.r, grown, ci, qi, cj, qj);
    } else if (law == SDR_LAW_CRITICAL_STRETCH) {
      const sdr_flags grown = SDR_NAMED(grown_flags)(marked, block->flags[k], t.s, qi, qj);
      if (commit) {
        block->flags[k] = grown;
        fresh |= grown;
      }
      phi = ((grown & SDR_LOST_I ? zero : ci) + (grown & SDR_LOST_J ? zero : cj)) *
            SDR_NAMED(force_factor)(z, t.r);
    } else {
      phi = (ci + cj) * SDR_NAMED(force_factor)(z, t.r);
      if (marked) phi = block->flags[k] & SDR_CUT ? zero : phi;
    }
    const SDR_REAL fx = phi * (xx + ex), fy = phi * (xy + ey), fz = phi * (xz + ez);
    if (overlap) {
      F[0][k] = fx;
      if (components > 1) F[1][k] = fy;
      if (components > 2) F[2][k] = fz;
    } else {
      block->fi[0][k] += force_unit * (double)fx;
      block->fj[0][k] -= force_unit * (double)fx;
      if (components > 1) {
        block->fi[1][k] += force_unit * (double)fy;
        block->fj[1][k] -= force_unit * (double)fy;
      }
      if (components > 2) {
        block->fi[2][k] += force_unit * (double)fz;
        block->fj[2][k] -= force_unit * (double)fz;
      }
    }
  }
  return (fresh & (SDR_FRESH_I | SDR_FRESH_J)) != 0;
}

/* i and j sides apart, since a run along its own row overlaps itself. */
SDR_INLINE void SDR_NAMED(add_block)(const int components, const sdr_bond_body *body,
                                     const sdr_block *block, SDR_REAL F[3][SDR_BLOCK])
{
  const double unit = SDR_FORCE_UNIT(body);
  for (int a = 0; a < components; ++a) {
    double *const fi = block->fi[a], *const fj = block->fj[a];
    const SDR_REAL *const force = F[a];
#pragma omp simd
    for (int k = 0; k < block->count; ++k) fi[k] += unit * (double)force[k];
#pragma omp simd
    for (int k = 0; k < block->count; ++k) fj[k] -= unit * (double)force[k];
  }
}

SDR_INLINE void SDR_NAMED(force_of_runs)(const int components, const int law, const int each,
                                         const int commit, const sdr_bond_body *body, int64_t first,
                                         int64_t end, double *const u[3], double *const f[3])
{
  _Alignas(64) SDR_REAL F[3][SDR_BLOCK];
  for (int64_t r = first; r < end; ++r) {
    const sdr_bond_run *run = &body->bonds->runs[r];
    const int marked = body->run_marked && body->run_marked[r];
    const int overlap =
        SDR_BUFFERED || (run->j0 > run->i0 ? run->j0 - run->i0 : run->i0 - run->j0) < run->length;
    int fresh = 0;
    for (int32_t start = 0; start < run->length; start += SDR_BLOCK) {
      const sdr_block block = block_at(components, body, run, start, u, f);
      if (marked)
        fresh |= SDR_NAMED(block_force)(components, law, each, 1, commit, 1, body, &block, F);
      else if (overlap)
        fresh |= SDR_NAMED(block_force)(components, law, each, 0, commit, 1, body, &block, F);
      else
        fresh |= SDR_NAMED(block_force)(components, law, each, 0, commit, 0, body, &block, F);
      if (marked || overlap) SDR_NAMED(add_block)(components, body, &block, F);
    }
    if (law == SDR_LAW_CRITICAL_STRETCH && commit && fresh) body->run_fresh[r] = 1;
  }
}
