#include "image/exr_budget.h"

#include <stdint.h>
#include <stdlib.h>

/* OpenEXRCore passes nothing but a size to its allocator, so the budget cannot
 * be an argument. */
static _Thread_local exr_budget *selected;

/* Precedes each allocation, because budget_give() is not told the size. */
typedef union block {
  size_t size;
  max_align_t align;
} block;

void budget_select(exr_budget *budget) {
  selected = budget;
}

void *budget_take(size_t size) {
  exr_budget *b = selected;
  if (b && size > b->limit - b->held) {
    b->exceeded = 1;
    return NULL;
  }
  block *taken =
      size <= SIZE_MAX - sizeof *taken ? malloc(sizeof *taken + size) : NULL;
  if (!taken)
    return NULL;
  taken->size = size;
  if (b)
    b->held += size;
  return taken + 1;
}

void budget_give(void *memory) {
  block *taken = memory;
  if (!taken)
    return;
  if (selected)
    selected->held -= taken[-1].size;
  free(taken - 1);
}
