#include "output/pieces.h"

#include "base/memory.h"
#include "output/rundir.h"

#include <stdio.h>
#include <stdlib.h>

static void gather(const sdr_system *system, const int32_t *of, sdr_piece *pieces)
{
  const sdr_points *points = system->model->points;
  for (int32_t i = 0; i < system->count; ++i) {
    double v[3] = {0.0};
    if (of[i] < 0) continue;
    sdr_piece *piece = &pieces[of[i]];
    sdr_system_point(system, "velocity", i, v);
    ++piece->points;
    piece->mass += system->mass[i];
    for (int a = 0; a < system->components; ++a) {
      piece->centre[a] += system->mass[i] * (points->x[a][i] + system->u[a][i]);
      piece->velocity[a] += system->mass[i] * v[a];
    }
  }
}

/* Sums to means; a body at rest may have no masses. Returns 1 over the sum of the squares of the
   pieces' shares: as many equal pieces would be as uneven. */
static double settle(sdr_piece *pieces, int32_t count)
{
  double whole = 0.0, squares = 0.0;
  for (int32_t k = 0; k < count; ++k) {
    sdr_piece *piece = &pieces[k];
    for (int a = 0; a < 3 && piece->mass > 0.0; ++a) {
      piece->centre[a] /= piece->mass;
      piece->velocity[a] /= piece->mass;
    }
    whole += piece->mass;
    squares += piece->mass * piece->mass;
  }
  return squares > 0.0 ? whole * whole / squares : 0.0;
}

sdr_status sdr_pieces_find(sdr_system *system, double threshold, sdr_piece **pieces,
                           sdr_fragments *out)
{
  sdr_fragments fragments;
  sdr_piece *found = NULL;
  int32_t *of = sdr_alloc((size_t)system->count, sizeof *of);
  sdr_status status = SDR_RUN_FAILED;
  if (!of) return status;
  status = sdr_fragments_find(system, threshold, of, &fragments);
  if (status == SDR_OK && !(found = sdr_alloc((size_t)fragments.count, sizeof *found)))
    status = SDR_RUN_FAILED;
  if (status == SDR_OK) {
    gather(system, of, found);
    fragments.effective = settle(found, fragments.count);
    *pieces = found;
    *out = fragments;
  }
  sdr_free(of);
  return status;
}

static void put(FILE *out, int32_t k, const sdr_piece *piece)
{
  fprintf(out, "%d,%d,%.17g", (int)k, (int)piece->points, piece->mass);
  for (int a = 0; a < 3; ++a) fprintf(out, ",%.17g", piece->centre[a]);
  for (int a = 0; a < 3; ++a) fprintf(out, ",%.17g", piece->velocity[a]);
  fputc('\n', out);
}

sdr_status sdr_pieces_write(const char *directory, sdr_system *system, double threshold,
                            sdr_fragments *out)
{
  char *text = NULL;
  size_t size = 0;
  sdr_piece *pieces = NULL;
  SDR_TRY(sdr_pieces_find(system, threshold, &pieces, out));
  FILE *file = open_memstream(&text, &size);
  int failed = file == NULL;
  if (file) {
    fputs("piece,points,mass,x,y,z,vx,vy,vz\n", file);
    for (int32_t k = 0; k < out->count; ++k) put(file, k, &pieces[k]);
    failed = fclose(file) != 0;
  }
  const sdr_status status = failed ? sdr_fail(SDR_RUN_FAILED, "out of memory for fragments.csv")
                                   : sdr_rundir_write(directory, "fragments.csv", text);
  free(text);
  sdr_free(pieces);
  return status;
}
