/*
 * Small kernels for the layers, as one program: the padding around them, the
 * bounds over their cells, and the steps that are taken in them.  Each program
 * has a fixed cost, even if the driver has it in its cache, so the three share
 * one.
 *
 * Inputs, outputs, build defines and launch shapes are those of the three
 * files.
 */
#include "clear_padding.cl"
#include "bounds.cl"
#include "pattern.cl"
