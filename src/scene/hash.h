/* The number that tells whether two scenes run through the same states. */
#ifndef SDR_SCENE_HASH_H
#define SDR_SCENE_HASH_H

#include "scene/node.h"

#include <stdint.h>

/* FNV-1a over a read scene's tree, defaults included: keys in alphabetical order, numbers as their
   SI value to 15 digits (0.1 us is 100 ns). Left out is what only tells how far to run and what to
   show: title, output, figures, variants, threads, time.end, time.allow_unstable, damage.onset. */
uint64_t sdr_scene_tree_hash(const sdr_node *root);

#endif
