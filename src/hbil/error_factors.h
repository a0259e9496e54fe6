/* From the spread of the gathered light to the error of its mean. */
#ifndef HBIL_ERROR_FACTORS_H
#define HBIL_ERROR_FACTORS_H

#include <stdbool.h>

#include "names.h"
#include "shared.h"

hbil_error_args error_factors(int slices, int steps, bool finite_thickness,
                              bool half_resolution);

#endif
