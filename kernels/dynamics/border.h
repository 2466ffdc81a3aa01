// SPDX-License-Identifier: MIT
// Bits that tell of a place of one domain among many, for kernels and host alike. A thing that
// never moves has no bit.
#ifndef KERNELS_DYNAMICS_BORDER_H
#define KERNELS_DYNAMICS_BORDER_H

#define PLACE_OWN 1u
#define PLACE_MOVES 2u
#define PLACE_SENSOR 4u
#define PLACE_SHARED 8u // other domains' contacts, too, tell what is found of this body's

#define NO_PLACE 0xFFFFFFFFu // owner and other of a contact that is not here

#define NEAR_WORDS 8 // a place, bounds, and a spare word

#endif
