/* Speeds and direction of a crack's tip from the places that it has passed. */
#ifndef SDR_OUTPUT_CRACK_PATH_H
#define SDR_OUTPUT_CRACK_PATH_H

#include "output/crack_tree.h"

/* Paths are `count` nodes by distance, as sdr_crack_path gives them. NAN: not known. Times are
   those of looks, so nodes that were passed between two looks share one. A slope or a mean is known
   only over three different times: a whole interval between looks lies within. */

/* How many nodes there are before the crack jumped: passed more than `window` (m) of nodes, the
   first ones excepted, between two looks, where a ligament fails at once and no tip runs. Speeds
   are those of the path up to there. */
int32_t sdr_crack_run_up(const sdr_crack_node *path, int32_t count, double window);

/* Speed at node k by two places: the way from the latest node with an earlier time over the time
   it took, m/s (000 eq. 59). Of nodes that share a time, only the farthest has one. */
double sdr_crack_step_speed(const sdr_crack_node *path, int32_t count, int32_t k);

/* Speed, m/s: the slope, by least squares, of distance against arrival times of the nodes from
   distance `from` to `to` (m). The times are what is uncertain, so they are fitted. */
double sdr_crack_speed(const sdr_crack_node *path, int32_t count, double from, double to);

/* The same at node k in a window (m) around it, which is moved to lie within the path if it is
   long enough. */
double sdr_crack_speed_at(const sdr_crack_node *path, int32_t count, int32_t k, double window);

/* The largest over all windows that begin at a node and lie between `from` and the path's end. */
double sdr_crack_largest_speed(const sdr_crack_node *path, int32_t count, double from,
                               double window);

/* The way from distance `from` to the end over the time it took. */
double sdr_crack_mean_speed(const sdr_crack_node *path, int32_t count, double from);

/* When the tip got as far as `distance`, s. */
double sdr_crack_time_at(const sdr_crack_node *path, int32_t count, double distance);

/* Angle, radians in [0, pi], between direction[3] (a unit vector) and the line that fits the nodes
   from distance `from` to `to` by least squares. */
double sdr_crack_angle(const sdr_crack_node *path, int32_t count, const double direction[3],
                       double from, double to);

/* Speed of Rayleigh waves, m/s, by 000 eq. 60: sqrt(mu/rho) (0.87 + 1.12 nu)/(1 + nu). */
double sdr_rayleigh_speed(double young, double poisson, double density);

#endif
