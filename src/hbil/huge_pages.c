/* Large buffers of CPU devices, in memory of huge pages. */
#if defined(__linux__)
#define _DEFAULT_SOURCE /* posix_memalign(), madvise() */
#include <stdlib.h>
#include <sys/mman.h>
#endif

#include "huge_pages.h"

#if defined(__linux__) && defined(MADV_HUGEPAGE)

/* A huge page of x86-64, and of arm64 where others have 4 KiB. */
static const size_t huge_page = (size_t)2 << 20;
/* Below a few of them, the processor holds the addresses of small pages. */
static const size_t least_bytes = (size_t)8 << 20;

static void CL_CALLBACK free_pages(cl_mem buffer, void *pages) {
  (void)buffer;
  free(pages);
}

cl_mem create_on_huge_pages(cl_context context, size_t bytes) {
  void *pages = NULL;
  cl_int error = CL_SUCCESS;
  if (bytes < least_bytes || posix_memalign(&pages, huge_page, bytes))
    return NULL;
  /* It fails on systems without huge pages, where small ones will do. */
  (void)madvise(pages, bytes - bytes % huge_page, MADV_HUGEPAGE);
  cl_mem buffer = clCreateBuffer(
      context, CL_MEM_READ_WRITE | CL_MEM_USE_HOST_PTR, bytes, pages, &error);
  if (buffer && clSetMemObjectDestructorCallback(buffer, free_pages, pages) !=
                    CL_SUCCESS) {
    clReleaseMemObject(buffer);
    buffer = NULL;
  }
  if (!buffer)
    free(pages);
  return buffer;
}

#else

cl_mem create_on_huge_pages(cl_context context, size_t bytes) {
  (void)context;
  (void)bytes;
  return NULL;
}

#endif
