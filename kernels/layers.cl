/*
 * Small kernels for the layers, as one program: the padding around them, the
 * bounds over their cells, and the steps that are taken in them.  Whatever its
 * size, a program costs a compiler some time, even for one that it has compiled
 * before.
 *
 * Inputs, outputs, build defines and launch shapes are those of the three files.
 */
#include "clear.cl"
#include "bounds.cl"
#include "pattern.cl"
