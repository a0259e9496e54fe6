/* See shared_programs.h. */
#include "shared_programs.h"

#include <string.h>

static bool is_same(const binary_identity *a, const binary_identity *b) {
  return a->identity == b->identity && !strcmp(a->key, b->key);
}

cl_program shared_program(hbil_context *context,
                          const binary_identity *identity) {
  for (int i = 0; i < MOST_SHARED; ++i) {
    const cl_program program = context->shared.programs[i];
    if (program && is_same(&context->shared.identity[i], identity))
      return clRetainProgram(program) == CL_SUCCESS ? program : NULL;
  }
  return NULL;
}

void share_program(hbil_context *context, cl_program program,
                   const binary_identity *identity) {
  for (int i = 0; i < MOST_SHARED; ++i)
    if (context->shared.programs[i] &&
        is_same(&context->shared.identity[i], identity))
      return;
  if (clRetainProgram(program) != CL_SUCCESS)
    return;
  const int at = context->shared.next;
  if (context->shared.programs[at])
    clReleaseProgram(context->shared.programs[at]);
  context->shared.programs[at] = program;
  context->shared.identity[at] = *identity;
  context->shared.next = (at + 1) % MOST_SHARED;
}

void forget_shared_programs(hbil_context *context) {
  for (int i = 0; i < MOST_SHARED; ++i)
    if (context->shared.programs[i])
      clReleaseProgram(context->shared.programs[i]);
  memset(&context->shared, 0, sizeof context->shared);
}
