/* SPDX-License-Identifier: Apache-2.0 */
/* Worlds for tests, whose objects are all the same can: others take seconds to make. */
#ifndef TESTS_SYNTH_CANS_H
#define TESTS_SYNTH_CANS_H

#include "synth/workplace/workplace.h"
#include "tests/suite.h"

/* In arena memory */
static inline workplace_means cans_new(lt_arena *memory)
{
    enum { CAN = 4 };
    synth_body *body = lt_arena_alloc(memory, sizeof(*body));
    synth_prop_pair *prop = lt_arena_array(memory, YCB_COUNT, sizeof(*prop));
    lt_hand_model *hand;

    check_ok(synth_hand_new(memory, SYNTH_HAND_MANO_LIKE, &hand));
    check_ok(synth_body_new(memory, hand, body));
    check_ok(synth_prop_new_bare(memory, CAN, &prop[0].right));
    check_ok(synth_prop_mirror(memory, &prop[0].right, &prop[0].left));
    for (int i = 1; i < YCB_COUNT; i++)
        prop[i] = prop[0];
    return (workplace_means){ body, hand, prop };
}

static inline workplace_script cans_script(lt_arena *memory, const workplace_means *m, uint64_t seed, int frames)
{
    workplace_script s = { .body = m->body, .hand = m->hand, .prop = m->prop, .seed = seed, .frames = frames,
                           .difficulty = 0.2 };

    check_ok(workplace_script_new(memory, &s));
    return s;
}

#endif
