#include "app/figures.h"

#include "base/memory.h"
#include "output/measures.h"

#include <math.h>
#include <string.h>

enum { EVERY_RUN = 15 };

static const char *const names[EVERY_RUN] = {
    "onset_time", "imbalance",           "imbalance_largest", "through_cracks",
    "sectors",    "fragments",           "largest_share",     "dissipated",
    "damage_max", "damage_mean",         "momentum_linear",   "momentum_angular",
    "time_end",   "fragments_effective", "contact_closest"};

static void fill_in(const sdr_summary *s, const sdr_ring_counts *ring, sdr_measured *measured)
{
  const double values[EVERY_RUN] = {
      s->onset_time,
      s->books.imbalance_relative,
      s->books.imbalance_largest,
      ring->known ? (double)ring->cracks : (double)NAN,
      ring->known ? (double)ring->sectors : (double)NAN,
      s->fragments_known ? (double)s->fragments.count : (double)NAN,
      s->fragments_known ? (double)s->fragments.largest / (double)s->points : (double)NAN,
      s->books.dissipated,
      s->damage_max,
      s->damage_mean,
      s->books.linear_residual,
      s->books.angular_residual,
      s->time_end,
      s->fragments_known ? s->fragments.effective : (double)NAN,
      s->contact_closest};
  for (int k = 0; k < EVERY_RUN; ++k) measured[k].value = values[k];
}

static sdr_status add_measure(const sdr_measurement *measure, sdr_measured *out)
{
  for (int k = 0; k < EVERY_RUN; ++k)
    if (strcmp(names[k], measure->name) == 0)
      return sdr_fail(SDR_BAD_INPUT,
                      "%s: every run has a figure '%s'; give the measure another name",
                      sdr_origin_text(measure->origin), measure->name);
  *out = (sdr_measured){measure->name, (double)NAN, 1};
  return SDR_OK;
}

/* Of the cracks that are followed; `before`: what is measured beside them. */
static sdr_status add_cracks(const sdr_cracks_output *cracks, const sdr_crack_report *reports,
                             const sdr_measured *before, int count, sdr_measured *out)
{
  for (int t = 0; t < cracks->tip_count; ++t)
    for (int n = 0; n < SDR_CRACK_FIGURES; ++n) {
      const char *name = cracks->tip[t].figure[n];
      for (int k = 0; k < count; ++k)
        if (strcmp(before[k].name, name) == 0)
          return sdr_fail(SDR_BAD_INPUT,
                          "%s: tip %s has a figure '%s', and so has a measure; give one of them "
                          "another name",
                          sdr_origin_text(cracks->tip[t].origin), cracks->tip[t].name, name);
      const double value = reports ? reports[t].figure[n] : (double)NAN;
      out[t * SDR_CRACK_FIGURES + n] = (sdr_measured){name, value, 1};
    }
  return SDR_OK;
}

sdr_status sdr_figures_measured(const sdr_scene *scene, const sdr_summary *summary,
                                const sdr_ring_counts *ring, const sdr_observer *measures,
                                sdr_measured **out, int *count)
{
  const sdr_output_scene *output = &scene->output;
  const int others = EVERY_RUN + output->measure_count;
  const int all = others + output->cracks.tip_count * SDR_CRACK_FIGURES;
  sdr_measured *measured = sdr_alloc((size_t)all, sizeof *measured);
  sdr_status status = measured ? SDR_OK : SDR_RUN_FAILED;
  for (int k = 0; measured && k < EVERY_RUN; ++k)
    measured[k] = (sdr_measured){names[k], (double)NAN, 0};
  for (int k = 0; status == SDR_OK && k < output->measure_count; ++k) {
    status = add_measure(&output->measure[k], &measured[EVERY_RUN + k]);
    if (measures) measured[EVERY_RUN + k].value = sdr_measures_value(measures, k);
  }
  if (status == SDR_OK)
    status = add_cracks(&output->cracks, summary ? summary->cracks : NULL, measured, others,
                        measured + others);
  if (status != SDR_OK) {
    sdr_free(measured);
    return status;
  }
  if (summary) fill_in(summary, ring, measured);
  *out = measured;
  *count = all;
  return SDR_OK;
}

sdr_status sdr_figures_known(const sdr_scene *scene)
{
  sdr_measured *measured;
  int count;
  SDR_TRY(sdr_figures_measured(scene, NULL, NULL, NULL, &measured, &count));
  const sdr_status status = sdr_figures_check(scene, measured, count);
  sdr_free(measured);
  return status;
}

/* ---- in words -------------------------------------------------------------------------------- */

static void print_figure(const sdr_figure *figure, int width, double value, FILE *out)
{
  const int low = !isnan(figure->low), high = !isnan(figure->high);
  const int outside = isnan(value) || value < figure->low || value > figure->high;
  if (isnan(value))
    fprintf(out, "  %-*s none", width, figure->name);
  else
    fprintf(out, "  %-*s %.4g", width, figure->name, value);
  if (low && high)
    fprintf(out, ", accepted %.4g to %.4g", figure->low, figure->high);
  else if (low || high)
    fprintf(out, ", accepted %s %.4g", low ? "from" : "up to", low ? figure->low : figure->high);
  if ((low || high) && outside) fprintf(out, ": OUTSIDE");
  if (!isnan(figure->paper)) fprintf(out, ", the paper's %.4g", figure->paper);
  fputc('\n', out);
}

static const sdr_figure *find_figure(const sdr_scene *scene, const char *name)
{
  for (int f = 0; f < scene->figure_count; ++f)
    if (strcmp(scene->figure[f].name, name) == 0) return &scene->figure[f];
  return NULL;
}

static int widest_name(const sdr_summary *s)
{
  int width = 17;
  for (int k = 0; k < s->measured_count; ++k) {
    const int length = (int)strlen(s->measured[k].name);
    if (s->measured[k].always && length > width) width = length;
  }
  return width;
}

void sdr_figures_print(const sdr_summary *s, FILE *out)
{
  const int width = widest_name(s);
  if (s->scene->figure_count > 0 || s->scene->output.measure_count > 0)
    fprintf(out, "figures (SI)\n");
  for (int f = 0; f < s->scene->figure_count; ++f)
    for (int k = 0; k < s->measured_count; ++k)
      if (strcmp(s->scene->figure[f].name, s->measured[k].name) == 0)
        print_figure(&s->scene->figure[f], width, s->measured[k].value, out);
  for (int k = 0; k < s->measured_count; ++k) {
    sdr_figure bare = {.low = NAN, .high = NAN, .paper = NAN};
    if (!s->measured[k].always || find_figure(s->scene, s->measured[k].name)) continue;
    snprintf(bare.name, sizeof bare.name, "%s", s->measured[k].name);
    print_figure(&bare, width, s->measured[k].value, out);
  }
}
