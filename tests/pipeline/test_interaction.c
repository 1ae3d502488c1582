/* SPDX-License-Identifier: Apache-2.0 */
/*
 * The rules of interaction on what is true of drawn worlds, beside the state that the generator's programs were in: the
 * share of frames that agree, more than five frames from a change.
 */
#include "libtensor/base/parallel.h"
#include "libtensor/geometry/mat3.h"
#include "pipeline/watch/internal.h"
#include "synth/workplace/clock.h"
#include "synth/workplace/truth.h"
#include "tests/scratch.h"
#include "tests/synth/cans.h"

#include <math.h>

enum { FRAMES = 600, FROM_CHANGE = 5 };
enum { WRIST_NODE = 12, LEFT_HAND_NODES = 25, HAND_NODES = 20 };

static const double TOUCHES = 0.005;            /* metres */
static const double FRAME = 1.0 / WORKPLACE_FPS;

static workplace_means means;

static void setup(void)
{
    open_scratch();
    lt_set_threads(1);
    means = cans_new(arena);
}

/* ---- a world as watch would know it, if it knew all --------------------------------------------------------- */

typedef struct {
    workplace_script script;
    synth_room *room;
    watch_options o;
    watch_world w;
    int before;                     /* frames that were seen */
} world;

static world *open_world(uint64_t seed)
{
    world *d = lt_arena_alloc(arena, sizeof(*d));

    d->script = cans_script(arena, &means, seed, FRAMES);
    check_ok(workplace_room(arena, &d->script, &d->room));
    workplace_rig(&d->script, 1, 1, &d->o.rig);
    d->w = (watch_world){ .o = &d->o, .n_people = d->script.n_people };
    for (int i = 0; i < d->w.n_people; i++)
        d->w.person[i].id = 1 + i;
    for (int i = 0; i < 2 * d->w.n_people; i++)
        d->w.thing[d->w.n_things++] = (watch_thing){ .id = 11 + i, .kind = DETECTED_HAND, .person = 1 + i / 2,
            .side = i % 2 ? PREDICT_RIGHT : PREDICT_LEFT, .state = LT_FILTER_ON, .placed = true };
    for (int i = 0; i < d->script.n_objects; i++)
        d->w.thing[d->w.n_things++] = (watch_thing){ .id = 21 + i, .kind = DETECTED_OBJECT, .placed = true,
            .name = d->script.object[i].prop->right.name, .support = NAN };
    return d;
}

static void move(const world *d, watch_thing *t, const double to[3])
{
    for (int k = 0; k < 3; k++) {
        t->centre.v[k] = d->before ? (to[k] - t->centre.x[k]) / FRAME : 0;
        t->centre.x[k] = to[k];
    }
}

static void move_person(world *d, const workplace_scene *c, int i)
{
    watch_person *p = &d->w.person[i];
    double node[BODY_NODES][3];

    body_nodes(c->vertex[i][0], c->who[i].body.joint[0], node);
    memcpy(p->joint, node, sizeof(p->joint));
    p->action = (watch_action){ .cls = c->who[i].act ? (int)c->who[i].act->draw.cls : -1, .p = 1 };
    for (int side = 0; side < 2; side++) {
        watch_thing *h = &d->w.thing[2 * i + side];

        memcpy(h->joint[0].x, node[WRIST_NODE + side], sizeof(double[3]));
        for (int j = 0; j < HAND_NODES; j++)
            memcpy(h->joint[1 + j].x, node[LEFT_HAND_NODES + side * HAND_NODES + j], sizeof(double[3]));
        move(d, h, h->joint[9].x);
    }
}

static void touch(world *d, const workplace_scene *c, int side, int object, double t)
{
    const int64_t h = 11 + side, o = 21 + object;
    const bool touching = truth_contact(c, side / 2, side % 2, object) <= TOUCHES;
    watch_contact *k = d->w.contact;

    while (k < d->w.contact + d->w.n_contacts && (k->hand != h || k->object != o))
        k++;
    if (k == d->w.contact + d->w.n_contacts) {
        ck_assert_int_lt(d->w.n_contacts, WATCH_CONTACTS);
        d->w.n_contacts++;
        *k = (watch_contact){ .hand = h, .object = o };
    }
    watch_contact_step(k, touching, t);
}

static void see(world *d, const workplace_scene *c)
{
    const double t = workplace_time(c->k);

    for (int i = 0; i < d->script.n_people; i++)
        move_person(d, c, i);
    for (int i = 0; i < d->script.n_objects; i++) {
        double centre[3];

        lt_rigid_apply(c->object[i].R, c->object[i].t, d->script.object[i].middle, centre);
        move(d, &d->w.thing[2 * d->script.n_people + i], centre);
        for (int side = 0; side < 2 * d->script.n_people; side++)
            touch(d, c, side, i, t);
    }
    check_ok(watch_interactions_run(&d->w, &(watch_set){ .number = c->k, .t = t }));
    d->before++;
}

/* ---- agreement ------------------------------------------------------------------------------------------------ */

typedef struct { int right[INTERACTION_STATES], all[INTERACTION_STATES]; } tally;

static bool far_from_change(const uint8_t *state, int k)
{
    for (int i = k - FROM_CHANGE; i <= k + FROM_CHANGE; i++)
        if (i < 0 || i >= FRAMES || state[i] != state[k])
            return false;
    return true;
}

static void play(uint64_t seed, tally *sum)
{
    static uint8_t truth[WORKPLACE_PEOPLE][FRAMES], said[WORKPLACE_PEOPLE][FRAMES];
    world *d = open_world(seed);
    lt_arena *frame = lt_arena_new();

    for (int k = 0; k < FRAMES; k++) {
        workplace_scene *c;

        lt_arena_reset(frame);
        check_ok(workplace_scene_at(frame, &d->script, d->room, k, &c));
        see(d, c);
        for (int i = 0; i < d->script.n_people; i++) {
            truth[i][k] = (uint8_t)c->who[i].state;
            said[i][k] = (uint8_t)d->w.person[i].interaction.state;
        }
    }
    lt_arena_free(frame);
    for (int i = 0; i < d->script.n_people; i++)
        for (int k = 0; k < FRAMES; k++)
            if (far_from_change(truth[i], k)) {
                sum->all[truth[i][k]]++;
                sum->right[truth[i][k]] += said[i][k] == truth[i][k];
            }
}

/* A seed by which no rule was chosen. */
START_TEST(true_inputs)
{
    tally sum = { { 0 }, { 0 } };
    int right = 0, all = 0;

    play(201, &sum);
    for (int s = 0; s < INTERACTION_STATES; s++) {
        printf("%-8s %5d of %5d\n", interaction_names[s], sum.right[s], sum.all[s]);
        right += sum.right[s];
        all += sum.all[s];
    }
    printf("%d of %d frames agree\n", right, all);
    ck_assert_double_ge(right, 0.9 * all);
}
END_TEST

static void add_tests(TCase *tc)
{
    tcase_add_unchecked_fixture(tc, setup, close_scratch);
    tcase_set_timeout(tc, 0);
    tcase_add_test(tc, true_inputs);
}

int main(void)
{
    setenv("CK_FORK", "no", 1);         /* the threads that parallel loops leave do not survive a fork */
    return run_suite("interaction", add_tests);
}
