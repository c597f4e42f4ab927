#include "base/parallel.h"

#ifdef _OPENMP
#include <omp.h>
#endif
#if defined(__SSE2__)
#include <immintrin.h>
#endif

static int thread_count = 0;

int sdr_threads(void)
{
#ifdef _OPENMP
  if (thread_count == 0) thread_count = omp_get_max_threads();
#else
  thread_count = 1;
#endif
  return thread_count;
}

void sdr_set_threads(int threads)
{
#ifdef _OPENMP
  thread_count = threads < 1 ? 1 : threads > 256 ? 256 : threads;
#else
  (void)threads;
#endif
}

/* Flush denormals to zero in this thread; gives the former mode back. */
static unsigned flush_denormals(void)
{
#if defined(__SSE2__)
  const unsigned mode = _mm_getcsr();
  _mm_setcsr(mode | 0x8040u); /* FTZ and DAZ */
  return mode;
#else
  return 0;
#endif
}

static void restore_denormals(unsigned mode)
{
#if defined(__SSE2__)
  _mm_setcsr(mode);
#else
  (void)mode;
#endif
}

static void run_here(int first, int end, int stride, sdr_task task, void *context)
{
  const unsigned mode = flush_denormals();
  for (int k = first; k < end; k += stride) task(context, k);
  restore_denormals(mode);
}

void sdr_parallel_for(int first, int end, int stride, sdr_task task, void *context)
{
#ifdef _OPENMP
  const int tasks = end > first ? (end - first + stride - 1) / stride : 0;
  const int threads = sdr_threads() < tasks ? sdr_threads() : tasks;
  if (threads > 1) {
#pragma omp parallel num_threads(threads)
    {
      const unsigned mode = flush_denormals();
#pragma omp for schedule(dynamic, 1)
      for (int k = 0; k < tasks; ++k) task(context, first + k * stride);
      restore_denormals(mode);
    }
    return;
  }
#endif
  run_here(first, end, stride, task, context);
}
