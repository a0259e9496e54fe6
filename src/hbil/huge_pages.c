/* Large buffers of CPU devices, in memory of huge pages. */
#if defined(__linux__)
#define _DEFAULT_SOURCE /* MAP_ANONYMOUS, madvise() */
#include <stdlib.h>
#include <sys/mman.h>
#endif

#include "huge_pages.h"

#if defined(__linux__) && defined(MADV_HUGEPAGE)

/* The size of a huge page of x86-64, and of arm64 with small pages of 4 KiB. */
static const size_t huge_page = (size_t)2 << 20;
/* Smaller buffers gain little: the TLB covers most of their small pages. */
static const size_t least_bytes = (size_t)8 << 20;

typedef struct mapping {
  void *start;
  size_t bytes;
} mapping;

static void unmap(mapping *m) {
  munmap(m->start, m->bytes);
  free(m);
}

static void CL_CALLBACK unmap_with_buffer(cl_mem buffer, void *pages) {
  (void)buffer;
  unmap(pages);
}

/* Maps `bytes` from a multiple of a huge page on; NULL if it cannot. */
static mapping *map(size_t bytes, char **aligned) {
  mapping *m = malloc(sizeof *m);
  if (!m)
    return NULL;
  m->bytes = bytes + huge_page;
  m->start = mmap(NULL, m->bytes, PROT_READ | PROT_WRITE,
                  MAP_PRIVATE | MAP_ANONYMOUS, -1, 0);
  if (m->start == MAP_FAILED) {
    free(m);
    return NULL;
  }
  *aligned = (char *)m->start + (huge_page - (size_t)m->start % huge_page);
  /* It fails on systems without huge pages, where small ones will do. */
  (void)madvise(*aligned, bytes - bytes % huge_page, MADV_HUGEPAGE);
  return m;
}

cl_mem create_on_huge_pages(cl_context context, size_t bytes) {
  char *aligned = NULL;
  mapping *pages = bytes < least_bytes ? NULL : map(bytes, &aligned);
  if (!pages)
    return NULL;
  cl_mem buffer = clCreateBuffer(
      context, CL_MEM_READ_WRITE | CL_MEM_USE_HOST_PTR, bytes, aligned, NULL);
  if (buffer && clSetMemObjectDestructorCallback(buffer, unmap_with_buffer,
                                                 pages) == CL_SUCCESS)
    return buffer;
  if (buffer)
    clReleaseMemObject(buffer);
  unmap(pages);
  return NULL;
}

#else

cl_mem create_on_huge_pages(cl_context context, size_t bytes) {
  (void)context;
  (void)bytes;
  return NULL;
}

#endif
