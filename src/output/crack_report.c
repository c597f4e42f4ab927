#include "output/crack_report.h"

#include "base/memory.h"
#include "output/crack_path.h"

#include <math.h>
#include <stdlib.h>

static int by_time(const void *left, const void *right)
{
  const sdr_crack_fork *a = left, *b = right;
  if (a->time < b->time || b->time < a->time) return a->time < b->time ? -1 : 1;
  return (a->distance > b->distance) - (a->distance < b->distance);
}

/* Where arm `a` left its parent; `path` is scratch. */
static sdr_crack_fork fork_of(const sdr_crack_tree *tree, int32_t a, double window,
                              sdr_crack_node *path)
{
  const sdr_crack_arm *arm = &tree->arm[a];
  sdr_crack_fork fork = {.speed = (double)NAN};
  const int at_notch = arm->left_at < 0;
  const sdr_crack_node *node = &tree->node[at_notch ? arm->first : arm->left_at];
  fork.time = node->time;
  fork.distance = node->distance;
  for (int c = 0; c < 3; ++c) fork.x[c] = node->x[c];
  if (at_notch) return fork;
  int32_t count = sdr_crack_path(tree, arm->parent, path);
  count = sdr_crack_run_up(path, count, window);
  for (int32_t k = 0; k < count; ++k)
    if (!(path[k].distance < node->distance)) {
      fork.speed = sdr_crack_speed_at(path, count, k, window);
      break;
    }
  return fork;
}

static sdr_status find_forks(sdr_crack_report *report, double window, sdr_crack_node *path)
{
  const sdr_crack_tree *tree = &report->tree;
  if (tree->arm_count < 2) return SDR_OK;
  report->fork = sdr_alloc((size_t)tree->arm_count - 1, sizeof *report->fork);
  if (!report->fork) return SDR_RUN_FAILED;
  for (int32_t a = 1; a < tree->arm_count; ++a)
    report->fork[report->fork_count++] = fork_of(tree, a, window, path);
  qsort(report->fork, (size_t)report->fork_count, sizeof *report->fork, by_time);
  return SDR_OK;
}

static void fill_in_path(sdr_crack_report *report, const sdr_crack_how *how,
                         const double direction[3], const double fit[2], sdr_crack_node *path)
{
  double *f = report->figure;
  const int32_t count = sdr_crack_path(&report->tree, 0, path);
  const int32_t run = sdr_crack_run_up(path, count, how->window);
  f[SDR_CRACK_FIRST_TIME] = path[0].time;
  f[SDR_CRACK_START_TIME] = sdr_crack_time_at(path, count, how->moved);
  f[SDR_CRACK_MEAN_SPEED] = sdr_crack_mean_speed(path, run, how->moved);
  f[SDR_CRACK_MAX_SPEED] = sdr_crack_largest_speed(path, run, how->moved, how->window);
  f[SDR_CRACK_RAYLEIGH_SHARE] = f[SDR_CRACK_MAX_SPEED] / how->rayleigh;
  f[SDR_CRACK_ANGLE] = sdr_crack_angle(path, count, direction, fit[0], fit[1]);
}

static void fill_in_first_fork(sdr_crack_report *report)
{
  double *f = report->figure;
  const sdr_crack_fork *first = report->fork;
  f[SDR_CRACK_BRANCHES] = (double)report->fork_count;
  if (report->fork_count == 0) return;
  f[SDR_CRACK_BRANCH_TIME] = first->time;
  f[SDR_CRACK_BRANCH_X] = first->x[0];
  f[SDR_CRACK_BRANCH_Y] = first->x[1];
  f[SDR_CRACK_BRANCH_DISTANCE] = first->distance;
  f[SDR_CRACK_BRANCH_SPEED] = first->speed;
}

static sdr_status make(const sdr_crack_sites *sites, const sdr_crack_growth *growth,
                       const sdr_crack_how *how, const double direction[3], const double fit[2],
                       sdr_crack_report *report)
{
  sdr_crack_tree then = {0};
  SDR_TRY(sdr_crack_branch(sites, growth, how->count_at, how->shortest, &then));
  report->figure[SDR_CRACK_TIPS] = (double)then.arm_count;
  sdr_crack_tree_clear(&then);
  SDR_TRY(sdr_crack_branch(sites, growth, (double)HUGE_VAL, how->shortest, &report->tree));
  sdr_crack_node *path = sdr_alloc((size_t)report->tree.node_count, sizeof *path);
  if (!path) return SDR_RUN_FAILED;
  const sdr_status status = find_forks(report, how->window, path);
  if (report->tree.arm_count > 0) fill_in_path(report, how, direction, fit, path);
  fill_in_first_fork(report);
  sdr_free(path);
  return status;
}

sdr_status sdr_crack_report_make(const sdr_crack_sites *sites, const sdr_crack_growth *growth,
                                 const sdr_crack_how *how, const double direction[3],
                                 const double fit[2], sdr_crack_surface surface,
                                 sdr_crack_report *out)
{
  sdr_crack_report report = {.fork_count = 0};
  for (int k = 0; k < SDR_CRACK_FIGURES; ++k) report.figure[k] = (double)NAN;
  const sdr_status status = make(sites, growth, how, direction, fit, &report);
  if (status != SDR_OK) {
    sdr_crack_report_clear(&report);
    return status;
  }
  report.figure[SDR_CRACK_LENGTH] = sdr_crack_length(&report.tree);
  report.figure[SDR_CRACK_AREA] = surface.area;
  report.figure[SDR_CRACK_ENERGY] = surface.energy;
  if (surface.area > 0.0)
    report.figure[SDR_CRACK_TOUGHNESS_SHARE] = surface.energy / (surface.area * how->toughness);
  const double along = report.figure[SDR_CRACK_LENGTH] * how->thickness * how->toughness;
  if (along > 0.0) report.figure[SDR_CRACK_PATH_SHARE] = surface.energy / along; /* NAN is not */
  *out = report;
  return SDR_OK;
}

void sdr_crack_report_clear(sdr_crack_report *report)
{
  sdr_crack_tree_clear(&report->tree);
  sdr_free(report->fork);
  *report = (sdr_crack_report){.fork_count = 0};
}
