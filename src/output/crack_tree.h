/* A crack as a tree: its tips on their way from the notch, and where they branched. */
#ifndef SDR_OUTPUT_CRACK_TREE_H
#define SDR_OUTPUT_CRACK_TREE_H

#include "output/crack_growth.h"

/* A place that a tip has passed. */
typedef struct {
  double time;     /* s, when the crack first got this far */
  double distance; /* m, from the notch's tip along the crack */
  double x[3];     /* m, middle of the damaged points across the crack */
} sdr_crack_node;

/* The way of one tip, from the notch or from where it left another arm. */
typedef struct {
  int32_t parent;       /* the arm that it left; -1: it began at the notch */
  int32_t left_at;      /* the node at which; -1 */
  int32_t first, count; /* its nodes, by distance */
} sdr_crack_arm;

/* Arm 0 is the one that got farthest. A branch is an arm beyond it. */
typedef struct {
  int32_t node_count, arm_count;
  sdr_crack_node *node;
  sdr_crack_arm *arm;
} sdr_crack_tree;

/* The tree at time `until` (s). Points across the crack at about the same distance make a node; an
   arm counts if it is at least `shortest` (m) long, counted from where it left. Nodes are as far
   apart as the largest spacing of the crack's points. Owner: the caller, who clears. */
sdr_status sdr_crack_branch(const sdr_crack_sites *sites, const sdr_crack_growth *growth,
                            double until, double shortest, sdr_crack_tree *out);
void sdr_crack_tree_clear(sdr_crack_tree *tree);

/* The whole way of an arm's tip from the notch: path has room for node_count; returns how many. */
int32_t sdr_crack_path(const sdr_crack_tree *tree, int32_t arm, sdr_crack_node *path);

/* The sum of all arms' lengths, m. */
double sdr_crack_length(const sdr_crack_tree *tree);

#endif
