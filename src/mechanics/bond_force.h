/* Forces of runs in one kind of number, from bond_loop.h: SDR_REAL double or float, SDR_NAMED(x)
   its names. In float displacements come as whole numbers of a unit of length, so that their
   differences are exact, and forces go into whole numbers of a unit of force (SDR_WHOLE), whose
   sums are exact: what one end of a bond gets, the other loses. */

/* Kinematics of a pair without cancellation (theory sec. 2): z = (2 xi.eta + eta^2)/xi^2,
   r = sqrt(1 + z) = l/|xi|, stretch s = z/(1 + r), force factor z/(r (1 + r)) = s/r. */
typedef struct {
  SDR_REAL s, r;
} SDR_NAMED(sdr_stretch);

/* s without a division: r - 1 has lost digits where s is small; s^2 + 2 s = z gives them back by
   half a Newton step, which is exact there and does nothing elsewhere. */
SDR_INLINE SDR_NAMED(sdr_stretch) SDR_NAMED(stretch_of)(SDR_REAL z)
{
  const SDR_REAL one = (SDR_REAL)1, half = (SDR_REAL)0.5;
  /* l = 0: no direction, no force. 1 + z may cancel to 0 where xi + eta is what rounding left of
     it; over an r far below the square root of a rounding that would be a force without bounds. A
     sum instead of the larger of two, which gcc makes two ways of computing all that follows. */
  const SDR_REAL r = SDR_SQRT(SDR_ABS(one + z) + SDR_SMALLEST);
  const SDR_REAL rough = r - one, error = SDR_FMA(-rough, rough + (SDR_REAL)2, z);
  return (SDR_NAMED(sdr_stretch)){SDR_FMA(half, error, rough), r};
}

SDR_INLINE SDR_REAL SDR_NAMED(force_factor)(SDR_REAL z, SDR_REAL r)
{
  return z / (r * ((SDR_REAL)1 + r));
}

/* Stiffness that a pair has left: `soft` under tension, `whole` else. */
SDR_INLINE SDR_REAL SDR_NAMED(stiffness_left)(const int marked, SDR_REAL z, SDR_REAL k,
                                              SDR_REAL soft, SDR_REAL whole)
{
  const SDR_REAL zero = (SDR_REAL)0;
  SDR_REAL left = z > zero ? soft : whole;
  if (marked) {
    left = k == (SDR_REAL)SDR_STRETCH_PROTECTED ? whole : left;
    left = k == (SDR_REAL)SDR_STRETCH_CUT ? zero : left;
  }
  return left;
}

/* Stiffness times force factor of a pair of the variational law: the divisions by r (1 + r), by
   k^2 + q_i and by k^2 + q_j are one. */
SDR_INLINE SDR_REAL SDR_NAMED(variational_factor)(const int each, const int marked, SDR_REAL z,
                                                  SDR_REAL r, SDR_REAL kept, SDR_REAL ci,
                                                  SDR_REAL qi, SDR_REAL cj, SDR_REAL qj)
{
  const SDR_REAL one = (SDR_REAL)1;
  const SDR_REAL a = SDR_FMA(kept, kept, qi), b = each ? SDR_FMA(kept, kept, qj) : one;
  const SDR_REAL ab = a * b, rr = r * (one + r);
  const SDR_REAL all = one / (rr * ab), by_r = ab * all, by_ab = rr * all;
  const SDR_REAL intact_i = qi * b * by_ab, intact_j = each ? qj * a * by_ab : intact_i;
  const SDR_REAL soft = SDR_FMA(ci, intact_i * intact_i, cj * (intact_j * intact_j));
  return SDR_NAMED(stiffness_left)(marked, z, kept, soft, ci + cj) * (z * by_r);
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
SDR_INLINE sdr_flags SDR_NAMED(grown_flags)(sdr_flags before, SDR_REAL s, SDR_REAL qi, SDR_REAL qj)
{
  const SDR_REAL zero = (SDR_REAL)0, square = s * s;
  const sdr_flags broken =
      (s > zero && square > qi ? SDR_LOST_I : 0) | (s > zero && square > qj ? SDR_LOST_J : 0);
  const sdr_flags fresh = broken & ~before;
  return before & SDR_PROTECTED ? before : before | fresh | fresh << 2;
}

/* How much further the end of pair k of a block moved than its start. */
typedef struct {
  SDR_REAL x, y, z;
} SDR_NAMED(sdr_motion);

SDR_INLINE SDR_NAMED(sdr_motion)
    SDR_NAMED(pair_motion)(const int components, const sdr_block *block, int k)
{
  const SDR_REAL zero = (SDR_REAL)0;
  return (SDR_NAMED(sdr_motion)){SDR_DIFFERENCE(0), components > 1 ? SDR_DIFFERENCE(1) : zero,
                                 components > 2 ? SDR_DIFFERENCE(2) : zero};
}

/* z of a pair. */
SDR_INLINE SDR_REAL SDR_NAMED(elongation)(const int components, const SDR_NAMED(sdr_terms) * of,
                                          SDR_NAMED(sdr_motion) e)
{
  const SDR_REAL two = (SDR_REAL)2;
  SDR_REAL sum = (two * of->xi[0] + e.x) * e.x;
  if (components > 1) sum = SDR_FMA(two * of->xi[1] + e.y, e.y, sum);
  if (components > 2) sum = SDR_FMA(two * of->xi[2] + e.z, e.z, sum);
  return sum * of->inverse_square;
}

SDR_INLINE SDR_REAL SDR_NAMED(pair_elongation)(const int components,
                                               const SDR_NAMED(sdr_terms) * of,
                                               const sdr_block *block, int k)
{
  return SDR_NAMED(elongation)(components, of, SDR_NAMED(pair_motion)(components, block, k));
}

/* z and r of a pair, and its history. */
typedef struct {
  SDR_REAL z, r, kept;
} SDR_NAMED(sdr_aged);

/* Stiffness times force factor of pair k of a block: laws that soften. */
SDR_INLINE SDR_REAL SDR_NAMED(softened_factor)(const int law, const int each, const int marked,
                                               const sdr_bond_body *body,
                                               const SDR_NAMED(sdr_terms) * of,
                                               const sdr_block *block, int k,
                                               SDR_NAMED(sdr_aged) pair)
{
  const SDR_REAL c = (SDR_REAL)SDR_SHARED_STIFFNESS(body), q = (SDR_REAL)body->threshold;
  const SDR_REAL ci = of->wij * (each ? block->SDR_NAMED(ci)[k] : c);
  const SDR_REAL cj = of->wji * (each ? block->SDR_NAMED(cj)[k] : c);
  const SDR_REAL qi = each ? block->SDR_NAMED(qi)[k] : q;
  const SDR_REAL qj = each ? block->SDR_NAMED(qj)[k] : q;
  if (law == SDR_LAW_VARIATIONAL)
    return SDR_NAMED(variational_factor)(each, marked, pair.z, pair.r, pair.kept, ci, qi, cj, qj);
  /* the others have one form for all kinds of number */
  const double grown = pair.kept > (SDR_REAL)0 ? (double)pair.kept : 0.0;
  const SDR_REAL soft_i = (SDR_REAL)block_softening(law, each, body, block, k, 0, grown).left;
  const SDR_REAL soft_j =
      each ? (SDR_REAL)block_softening(law, each, body, block, k, 1, grown).left : soft_i;
  const SDR_REAL soft = SDR_FMA(ci, soft_i, cj * soft_j);
  return SDR_NAMED(stiffness_left)(marked, pair.z, pair.kept, soft, ci + cj) *
         SDR_NAMED(force_factor)(pair.z, pair.r);
}

/* Pairs of a block and those after them up to a whole vector: what is computed for the latter is
   thrown away, and their history is that of padding or of the same pair, computed twice. */
SDR_INLINE int SDR_NAMED(whole_vectors)(const sdr_block *block)
{
  const int lanes = (int)(64 / sizeof(SDR_REAL));
  return (block->count + lanes - 1) / lanes * lanes;
}

/* What a block's flags leave, as numbers like the others, so that the loop over the pairs works in
   whole vectors: 1 or 0 for the halves of each pair, and the z up to which it loses nothing. */
typedef struct {
  _Alignas(64) SDR_REAL i[SDR_BLOCK], j[SDR_BLOCK], limit[SDR_BLOCK];
} SDR_NAMED(sdr_left);

/* Runs that join the same two rows, shifted by a few points against each other, and their forces
   in a piece of SDR_BLOCK points of the first row: [run][component][pair], zero in the margins. */
typedef struct {
  int count;
  int64_t i[SDR_BAND], j[SDR_BAND]; /* of the first pair */
  int32_t length[SDR_BAND];
  _Alignas(64) SDR_WHOLE force[SDR_BAND][3][SDR_MARGIN + SDR_BLOCK + SDR_MARGIN];
  SDR_NAMED(sdr_left) left;              /* of the block at hand, if its run is flagged */
  float stretch[SDR_BLOCK + SDR_MARGIN]; /* histories that nobody keeps */
  sdr_flags flags[SDR_BLOCK + SDR_MARGIN];
} SDR_NAMED(sdr_band);

SDR_INLINE void SDR_NAMED(read_flags)(const sdr_block *block, SDR_NAMED(sdr_left) * left)
{
  const SDR_REAL zero = (SDR_REAL)0, one = (SDR_REAL)1, limit = (SDR_REAL)block->limit;
  const sdr_flags both = SDR_LOST_I | SDR_LOST_J;
  const int n = whole_lines(block);
#pragma omp simd
  for (int k = 0; k < n; ++k) {
    const sdr_flags flags = block->flags[k];
    const int over = (flags & both) == both || flags & SDR_PROTECTED;
    left->i[k] = flags & SDR_LOST_I ? zero : one;
    left->j[k] = flags & SDR_LOST_J ? zero : one;
    left->limit[k] = over ? (SDR_REAL)INFINITY : limit;
  }
}

/* How many of the lanes behind a block's last pair are stretched beyond its limit. */
SDR_INLINE SDR_REAL SDR_NAMED(beyond_behind)(const int components, const int flagged,
                                             const SDR_NAMED(sdr_terms) * of,
                                             const sdr_block *block, int n,
                                             const SDR_NAMED(sdr_left) * left)
{
  SDR_REAL beyond = (SDR_REAL)0;
  for (int k = block->count; k < n; ++k) {
    const SDR_REAL most = flagged ? left->limit[k] : (SDR_REAL)block->limit;
    if (SDR_NAMED(pair_elongation)(components, of, block, k) > most) beyond += (SDR_REAL)1;
  }
  return beyond;
}

/* Forces of a block's present bonds into F; `flagged`: `left` says which they are. In one loop,
   since no history is written. `watched`: 1 if a bond may be stretched so far that it breaks: the
   law must be asked, and F is void. */
SDR_INLINE int SDR_NAMED(force_of_present)(const int components, const int each, const int flagged,
                                           const int watched, const sdr_bond_body *body,
                                           const sdr_block *block, const SDR_NAMED(sdr_left) * left,
                                           SDR_WHOLE *const F[3])
{
  const SDR_NAMED(sdr_terms) of = SDR_NAMED(terms_of)(body, block->class);
  const SDR_REAL zero = (SDR_REAL)0, one = (SDR_REAL)1, limit = (SDR_REAL)block->limit;
  const SDR_REAL c = (SDR_REAL)SDR_SHARED_STIFFNESS(body);
  const int n = SDR_NAMED(whole_vectors)(block);
  SDR_WHOLE *const restrict fx = F[0], *const restrict fy = F[1], *const restrict fz = F[2];
  SDR_REAL beyond = zero; /* pairs, those behind the last one too */
#pragma omp simd reduction(+ : beyond)
  for (int k = 0; k < n; ++k) {
    const SDR_NAMED(sdr_motion) e = SDR_NAMED(pair_motion)(components, block, k);
    const SDR_REAL z = SDR_NAMED(elongation)(components, &of, e);
    const SDR_REAL ci = of.wij * (each ? block->SDR_NAMED(ci)[k] : c);
    const SDR_REAL cj = of.wji * (each ? block->SDR_NAMED(cj)[k] : c);
    const SDR_REAL whole = flagged ? ci * left->i[k] + cj * left->j[k] : ci + cj;
    const SDR_REAL factor = SDR_NAMED(force_factor)(z, SDR_NAMED(stretch_of)(z).r);
    const SDR_REAL phi = SDR_MEND(of, whole * factor);
    if (watched) beyond += z > (flagged ? left->limit[k] : limit) ? one : zero;
    fx[k] = (SDR_WHOLE)(phi * (of.xi[0] + e.x));
    if (components > 1) fy[k] = (SDR_WHOLE)(phi * (of.xi[1] + e.y));
    if (components > 2) fz[k] = (SDR_WHOLE)(phi * (of.xi[2] + e.z));
  }
  return watched && beyond > zero &&
         beyond > SDR_NAMED(beyond_behind)(components, flagged, &of, block, n, left);
}

/* A block's flags take the stretches in; what they leave goes to `left`. */
SDR_INLINE void SDR_NAMED(break_block)(const int components, const int each,
                                       const sdr_bond_body *body, const sdr_block *block,
                                       SDR_NAMED(sdr_left) * left)
{
  const SDR_NAMED(sdr_terms) of = SDR_NAMED(terms_of)(body, block->class);
  const SDR_REAL zero = (SDR_REAL)0, one = (SDR_REAL)1, q = (SDR_REAL)body->threshold;
  const int n = whole_lines(block);
#pragma omp simd
  for (int k = 0; k < n; ++k) {
    const SDR_REAL z = SDR_NAMED(pair_elongation)(components, &of, block, k);
    const SDR_REAL s = SDR_NAMED(stretch_of)(z).s;
    const SDR_REAL qi = each ? block->SDR_NAMED(qi)[k] : q;
    const SDR_REAL qj = each ? block->SDR_NAMED(qj)[k] : q;
    const sdr_flags grown = SDR_NAMED(grown_flags)(block->flags[k], s, qi, qj);
    block->new_flags[k] = grown;
    left->i[k] = grown & SDR_LOST_I ? zero : one;
    left->j[k] = grown & SDR_LOST_J ? zero : one;
  }
}

/* Forces of a block of run r into F: no law, or critical stretch, of which only blocks in which
   something may break have their flags written. */
SDR_INLINE void SDR_NAMED(force_of_block)(const int components, const int law, const int each,
                                          const sdr_bond_body *body, int64_t r,
                                          const sdr_block *block, SDR_NAMED(sdr_left) * left,
                                          SDR_WHOLE *const F[3])
{
  const int critical = law == SDR_LAW_CRITICAL_STRETCH;
  const int flagged = critical ? body->run_flagged[r] : body->run_marked && body->run_marked[r];
  if (flagged) SDR_NAMED(read_flags)(block, left);
  const int may_break =
      flagged ? SDR_NAMED(force_of_present)(components, each, 1, critical, body, block, left, F)
              : SDR_NAMED(force_of_present)(components, each, 0, critical, body, block, left, F);
  if (!critical || !may_break) return;
  SDR_NAMED(break_block)(components, each, body, block, left);
  SDR_NAMED(force_of_present)(components, each, 1, 0, body, block, left, F);
  if (body->commit && fresh_in(block)) body->run_fresh[r] = body->run_flagged[r] = 1;
}

/* Forces of a block into F, while its history takes the stretches in: laws that soften. In three
   loops: the way from displacement to force is so long that in one loop a processor would not see
   enough pairs at once to keep busy; and the history, in float, has a loop of its own, so that the
   others consist of whole vectors of one kind of number. */
SDR_INLINE void SDR_NAMED(force_of_softening)(const int components, const int law, const int each,
                                              const int marked, const sdr_bond_body *body,
                                              const sdr_block *block, SDR_WHOLE *const F[3])
{
  enum { MORE = 64 / sizeof(SDR_REAL) };
  const SDR_NAMED(sdr_terms) of = SDR_NAMED(terms_of)(body, block->class);
  const int n = SDR_NAMED(whole_vectors)(block), lines = whole_lines(block);
  SDR_WHOLE *const restrict fx = F[0], *const restrict fy = F[1], *const restrict fz = F[2];
  _Alignas(64) SDR_REAL Z[SDR_BLOCK], R[SDR_BLOCK], K[SDR_BLOCK + MORE], Y[3][SDR_BLOCK];
#pragma omp simd
  for (int k = 0; k < n; ++k) {
    const SDR_NAMED(sdr_motion) e = SDR_NAMED(pair_motion)(components, block, k);
    const SDR_REAL z = SDR_NAMED(elongation)(components, &of, e);
    const SDR_NAMED(sdr_stretch) t = SDR_NAMED(stretch_of)(z);
    Z[k] = z;
    R[k] = t.r;
    K[k] = t.s;
    Y[0][k] = of.xi[0] + e.x;
    if (components > 1) Y[1][k] = of.xi[1] + e.y;
    if (components > 2) Y[2][k] = of.xi[2] + e.z;
  }
  memset(K + n, 0, MORE * sizeof *K);
#pragma omp simd
  for (int k = 0; k < lines; ++k) {
    const float grown = SDR_NAMED(grown_stretch)(marked, block->stretch[k], K[k]);
    block->new_stretch[k] = grown;
    K[k] = (SDR_REAL)grown;
  }
#pragma omp simd
  for (int k = 0; k < n; ++k) {
    const SDR_NAMED(sdr_aged) pair = {Z[k], R[k], K[k]};
    const SDR_REAL phi =
        SDR_MEND(of, SDR_NAMED(softened_factor)(law, each, marked, body, &of, block, k, pair));
    fx[k] = (SDR_WHOLE)(phi * Y[0][k]);
    if (components > 1) fy[k] = (SDR_WHOLE)(phi * Y[1][k]);
    if (components > 2) fz[k] = (SDR_WHOLE)(phi * Y[2][k]);
  }
}

SDR_INLINE void SDR_NAMED(force_by_law)(const int components, const int law, const int each,
                                        const sdr_bond_body *body, int64_t r,
                                        const sdr_block *block, SDR_NAMED(sdr_left) * left,
                                        SDR_WHOLE *const F[3])
{
  if (!sdr_law_softens(law))
    SDR_NAMED(force_of_block)(components, law, each, body, r, block, left, F);
  else if (body->run_marked && body->run_marked[r])
    SDR_NAMED(force_of_softening)(components, law, each, 1, body, block, F);
  else
    SDR_NAMED(force_of_softening)(components, law, each, 0, body, block, F);
}

/* f += unit times the sum of `count` forces: once for all runs of a band, since what costs most is
   to write to points that do not begin on a cache line. */
static __attribute__((noinline)) void SDR_NAMED(add_up)(int count, const SDR_WHOLE *const force[],
                                                        double unit, int32_t points, double *f)
{
  const SDR_WHOLE *const a = force[0], *const b = force[1], *const c = force[2];
  const SDR_WHOLE *const d = force[3], *const e = force[4];
#define SDR_ADD_UP(sum)                                                                            \
  _Pragma("omp simd") for (int32_t k = 0; k < points; ++k) f[k] = SDR_SUM(unit, SDR_WIDE(sum), f[k])
  switch (count) {
  case 1:
    SDR_ADD_UP(a[k]);
    break;
  case 2:
    SDR_ADD_UP(a[k] + b[k]);
    break;
  case 3:
    SDR_ADD_UP((a[k] + b[k]) + c[k]);
    break;
  case 4:
    SDR_ADD_UP((a[k] + b[k]) + (c[k] + d[k]));
    break;
  default:
    SDR_ADD_UP((a[k] + b[k]) + (c[k] + d[k]) + e[k]);
  }
#undef SDR_ADD_UP
}

/* Add a band's forces to the points that its runs begin at. */
SDR_INLINE void SDR_NAMED(add_band)(const int components, SDR_NAMED(sdr_band) * band,
                                    const int64_t first[SDR_BAND], double unit, double *const f[3])
{
  int64_t low = first[0], high = first[0] + band->length[0];
  for (int c = 1; c < band->count; ++c) {
    low = first[c] < low ? first[c] : low;
    high = first[c] + band->length[c] > high ? first[c] + band->length[c] : high;
  }
  for (int a = 0; a < components; ++a) {
    const SDR_WHOLE *force[SDR_BAND] = {NULL};
    for (int c = 0; c < band->count; ++c)
      force[c] = band->force[c][a] + SDR_MARGIN - (first[c] - low);
    SDR_NAMED(add_up)(band->count, force, unit, (int32_t)(high - low), f[a] + low);
  }
}

/* Forces of a band's piece, and their bits if they are whole. */
SDR_INLINE int32_t SDR_NAMED(force_of_band)(const int components, const int law, const int each,
                                            const sdr_bond_body *body, const sdr_band_piece *piece,
                                            double *const u[3], double *const f[3],
                                            SDR_NAMED(sdr_band) * band)
{
  int32_t bits = 0;
  band->count = 0;
  for (int64_t r = piece->run; r < piece->run_end; ++r) {
    const sdr_bond_run *run = &body->bonds->runs[r];
    sdr_block block = block_at(components, body, run, piece->from, piece->end, u);
    block.new_stretch = body->commit ? block.stretch : band->stretch;
    block.new_flags = body->commit ? block.flags : band->flags;
    if (law == SDR_LAW_CRITICAL_STRETCH) block.limit = body->run_limit[r];
    fetch_next(law, body, piece, r, piece->runs_end);
    if (block.count <= 0) continue;
    const int c = band->count++;
    SDR_WHOLE *const F[3] = {band->force[c][0] + SDR_MARGIN, band->force[c][1] + SDR_MARGIN,
                             band->force[c][2] + SDR_MARGIN};
    SDR_NAMED(force_by_law)(components, law, each, body, r, &block, &band->left, F);
    for (int a = 0; a < components; ++a)
      memset(F[a] + block.count, 0, SDR_MARGIN * sizeof(SDR_WHOLE));
    bits |= SDR_BITS(body, components, F, block.count);
    band->i[c] = block.i;
    band->j[c] = block.j;
    band->length[c] = block.count;
  }
  if (band->count == 0) return 0;
  SDR_NAMED(add_band)(components, band, band->i, SDR_FORCE_UNIT(body), f);
  SDR_NAMED(add_band)(components, band, band->j, -SDR_FORCE_UNIT(body), f);
  return bits;
}

SDR_INLINE int32_t SDR_NAMED(force_of_runs)(const int components, const int law, const int each,
                                            const sdr_bond_body *body, int64_t first, int64_t end,
                                            double *const u[3], double *const f[3])
{
  SDR_NAMED(sdr_band) band;
  int32_t bits = 0;
  for (int c = 0; c < SDR_BAND; ++c)
    for (int a = 0; a < components; ++a)
      memset(band.force[c][a], 0, SDR_MARGIN * sizeof(SDR_WHOLE));
  for (int64_t r = first; r < end;) {
    sdr_band_piece piece = {.run = r, .run_end = end, .runs_end = end};
    find_band(body->bonds->runs, &piece);
    for (; piece.from < piece.last; piece.from = piece.end) {
      piece.end = piece.last - piece.from < SDR_BLOCK ? piece.last : piece.from + SDR_BLOCK;
      bits |= SDR_NAMED(force_of_band)(components, law, each, body, &piece, u, f, &band);
    }
    r = piece.run_end;
  }
  return bits;
}
