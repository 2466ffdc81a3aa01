// SPDX-License-Identifier: MIT
// Contacts into blocks of constraints, and their impulses back: prepare_constraint.clh has what is done to each.
//
//   spans   of each colour: first in the list, count, first slot
//   list    contacts by colour
//   blocks  constraints
//   each    contacts of a colour that a work-item takes

__kernel void prepare_contacts(PREPARE_CONTACTS_ARGS)
{
    const source from = {PREPARE_CONTACTS_VALUES};
    colour_parts parts = COLOUR_PARTS;
    colour_part part;
    for (uint colour = from_colour; colour < to_colour; ++colour) {
        BEGIN_COLOUR(parts, colour);
        while (next_part(&parts, &part))
            for (uint k = part.from; k < part.to; k += part.stride)
                prepare_part(blocks, &from, list, &part, k);
        END_COLOUR(parts);
    }
}

// The impulses of the last substep. A work-item takes its contacts of every colour, one by one.
__kernel void store_impulses(STORE_IMPULSES_ARGS)
{
    for (uint colour = from_colour; colour < to_colour; ++colour) {
        const colour_part part = PART_OF(colour);
        for (uint k = part.from; k < part.to; ++k) {
            ask_for(contacts + (size_t)list[part.first + min(k + 8, part.to - 1)] * RECORD + HEAD);
            store_contact(constraint_at(blocks, &part, k), contacts + (size_t)list[part.first + k] * RECORD);
        }
    }
}
