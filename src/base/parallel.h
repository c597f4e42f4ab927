/* Loops over independent tasks on the threads of one machine. */
#ifndef SDR_BASE_PARALLEL_H
#define SDR_BASE_PARALLEL_H

/* A task's body: `context` is shared and read-only in what tasks do not own. */
typedef void (*sdr_task)(void *context, int index);

/* Threads that sdr_parallel_for may use: the number set, at first all processors allowed to this
   process (or OMP_NUM_THREADS); 1 in a build without OpenMP. */
int sdr_threads(void);
void sdr_set_threads(int threads); /* clamped to 1..256 */

/* Call task(context, k) once for each k in [first, end) with steps of `stride`, on at most
   sdr_threads() threads, in any order; returns when all are done. In every task denormal numbers
   count as zero (ahead of a wave front displacements decay into them, at 1.3 times the cost). */
void sdr_parallel_for(int first, int end, int stride, sdr_task task, void *context);

#endif
