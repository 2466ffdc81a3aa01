// SPDX-License-Identifier: MIT
// Bits that tell of a place of one domain among many, for kernels and host alike. A thing that
// never moves has no bit.
#ifndef KERNELS_DYNAMICS_BORDER_H
#define KERNELS_DYNAMICS_BORDER_H

#define PLACE_OWN 1u
#define PLACE_MOVES 2u
#define PLACE_SENSOR 4u
#define PLACE_SHARED 8u // other domains' contacts, too, tell what is found of this body's
#define PLACE_SENT 16u  // other domains have it as a ghost

#define NO_PLACE 0xFFFFFFFFu // owner and other of a contact that is not here

#define NEAR_WORDS 8 // a place, bounds, and a spare word

// Which contacts are listed: those that wait for a colour, or are solved in order; those of ghosts
// that push; and of those that touch the ones that have a shared end, or whose first end that moves
// is a shared own body.
#define LISTED_WAITING 0
#define LISTED_GHOSTS 1
#define LISTED_SHARED 2
#define LISTED_SENT 3

// Bits of a listed contact: its colour, beside it COLOUR_LEFT, and whether it is solved here.
#define BORDER_COLOUR 63u
#define BORDER_SOLVED 128u

// Keys of a colour that contacts of a domain are sorted by: those of contacts that have a ghost, or a body that is
// one elsewhere, and then those of the others (COLOUR_KEYS of records.h each).
#define BORDER_KEYS 8

// Words of a ghost: colours of its contacts at home, of those that are solved here, after which it
// comes, and of those that are asked for.
#define GHOST_AT_HOME 0
#define GHOST_HERE 1
#define GHOST_ASKED 3
#define GHOST_WORDS 4

// Words that find what is solved. After each colour: since which colour ghosts have not come, how
// many were taken since, after which they came, and whether a ghost lacks something. Then which
// colours there are, how many solved contacts have another domain's owner, and how many that came
// were not those that were meant.
#define CLOSING_CAME 0
#define CLOSING_TAKEN 32
#define CLOSING_BROUGHT 64
#define CLOSING_LACKS 96
#define CLOSING_PRESENT 128
#define CLOSING_FOREIGN 129
#define CLOSING_MISTAKEN 130
#define CLOSING_WORDS 131

// A contact that was asked for: owner's and other's ids, touches, and its record.
#define ASKED_RECORD 3

#endif
