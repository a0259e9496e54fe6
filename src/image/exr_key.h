/*
 * The header attributes that store image.key, image.near_radius and
 * image.ao_radius.
 */
#ifndef HBIL_IMAGE_EXR_KEY_H
#define HBIL_IMAGE_EXR_KEY_H

#define EXR_KEY "hbilKey"
#define EXR_NEAR_RADIUS "hbilNearRadius"
#define EXR_AO_RADIUS "hbilAoRadius"

#endif
