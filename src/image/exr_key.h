/*
 * The header attribute that stores image.key.
 */
#ifndef HBIL_IMAGE_EXR_KEY_H
#define HBIL_IMAGE_EXR_KEY_H

#define EXR_KEY "hbilKey"

#endif
