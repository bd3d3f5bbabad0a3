// tools/content/people: bodies whose skin holds together, clips that loop and stand on the floor.
#include "test.h"

#include "tools/content/people/body.h"
#include "tools/content/people/people.h"

#include <math.h>
#include <stdlib.h>

static struct shape shapes[PEOPLE_BODIES];
static struct skeleton skeletons[PEOPLE_BODIES];

static int make_bodies(void **state)
{
    NG_UNUSED(state);
    for (int b = 0; b < PEOPLE_BODIES; b++)
        assert_true(people_shape((enum people_body)b, &shapes[b], &skeletons[b]));
    return 0;
}

static int drop_bodies(void **state)
{
    NG_UNUSED(state);
    for (int b = 0; b < PEOPLE_BODIES; b++)
        shape_finish(&shapes[b]);
    return 0;
}

static void bodies_are_whole(void **state)
{
    NG_UNUSED(state);
    for (int b = 0; b < PEOPLE_BODIES; b++) {
        size_t triangles = 0;
        for (int i = 0; i < PEOPLE_PARTS; i++) {
            const struct shape_part *p = &shapes[b].parts[i];
            assert_true(p->triangles.count > 0);
            triangles += p->triangles.count / 3;
            for (size_t v = 0; v < p->vertices.count; v++) {
                const struct shape_vertex *at = &p->vertices.items[v];
                double sum = 0.0;
                for (int k = 0; k < 4; k++) {
                    assert_true(at->weights[k] >= 0.0 && at->joints[k] < PEOPLE_JOINTS);
                    sum += at->weights[k];
                }
                assert_true(fabs(sum - 1.0) < 1e-9);
                assert_true(fabs(vec3_length(at->normal) - 1.0) < 1e-6);
                assert_true(at->place.y > -1e-9 && at->place.y < 2.1 && fabs(at->place.x) < 1.15);
            }
            for (size_t t = 0; t < p->triangles.count; t++)
                assert_true(p->triangles.items[t] < p->vertices.count);
        }
        assert_in_range(triangles, 5000, 16500);
    }
}

static struct vec3 skinned(const struct shape_vertex *v, const struct pose *p)
{
    struct vec3 sum = vec3_make(0, 0, 0);
    double h = p->s->height;
    for (int k = 0; k < 4; k++) {
        int j = v->joints[k];
        struct vec3 from = vec3_sub(v->place, vec3_scale(p->s->rest[j], h));
        struct vec3 to = vec3_add(vec3_scale(p->place[j], h), quat_rotate(p->world[j], from));
        sum = vec3_add(sum, vec3_scale(to, v->weights[k]));
    }
    return sum;
}

static double turn_between(struct quat a, struct quat b)
{
    double d = fabs(a.x * b.x + a.y * b.y + a.z * b.z + a.w * b.w);
    return 2.0 * acos(fmin(d, 1.0));
}

// From the end of a clip to its beginning is as small a step as any other.
static void clips_loop_and_have_no_jump(void **state)
{
    NG_UNUSED(state);
    for (int c = 0; c < PEOPLE_CLIPS; c++) {
        int keys = people_clips[c].keys;
        struct pose first, before, now;
        people_pose(&skeletons[0], (enum people_clip)c, 0.0, &first);
        people_pose(&skeletons[0], (enum people_clip)c, 1.0, &now);
        for (int j = 0; j < PEOPLE_JOINTS; j++)
            assert_true(turn_between(first.local[j], now.local[j]) < 1e-6);
        before = first;
        for (int k = 1; k <= keys; k++) {
            people_pose(&skeletons[0], (enum people_clip)c, (double)k / keys, &now);
            for (int j = 0; j < PEOPLE_JOINTS; j++)
                if (turn_between(before.local[j], now.local[j]) > 1.0) {
                    char name[32];
                    skeleton_name(j, name);
                    fail_msg("%s: %s turns by %.2f between keys %d and %d", people_clips[c].name, name,
                             turn_between(before.local[j], now.local[j]), k - 1, k);
                }
            assert_true(vec3_length(vec3_sub(before.hips, now.hips)) < 0.08);
            before = now;
        }
    }
}

static void feet_stand_on_the_floor_and_bones_keep_their_length(void **state)
{
    NG_UNUSED(state);
    for (int b = 0; b < PEOPLE_BODIES; b++)
        for (int c = 0; c < PEOPLE_CLIPS; c++)
            for (int k = 0; k < people_clips[c].keys; k++) {
                struct pose p;
                people_pose(&skeletons[b], (enum people_clip)c, (double)k / people_clips[c].keys, &p);
                double low = 1.0;
                for (size_t v = 0; v < shapes[b].parts[PART_SHOES].vertices.count; v++)
                    low = fmin(low, skinned(&shapes[b].parts[PART_SHOES].vertices.items[v], &p).y);
                if (low < -0.006 || low > 0.03)
                    fail_msg("%s, %s, key %d: the lowest point of the shoes is at %.4f", people_body_names[b],
                             people_clips[c].name, k, low);
                for (int j = 1; j < PEOPLE_JOINTS; j++) {
                    int parent = skeletons[b].parent[j];
                    double rest = vec3_length(vec3_sub(skeletons[b].rest[j], skeletons[b].rest[parent]));
                    assert_true(fabs(vec3_length(vec3_sub(p.place[j], p.place[parent])) - rest) < 1e-9);
                }
            }
}

// Where the ground carries it, the foot of a walker moves as fast as the ground.
static void walking_feet_do_not_slide(void **state)
{
    NG_UNUSED(state);
    for (int b = 0; b < PEOPLE_BODIES; b++) {
        const struct skeleton *s = &skeletons[b];
        double ground = people_walk_speed(s) * people_clips[CLIP_WALK].seconds / s->height;
        for (int side = 0; side < 2; side++) {
            struct pose p[2];
            for (int i = 0; i < 2; i++)
                people_pose(s, CLIP_WALK, 0.5 * side + 0.12 + 0.16 * i, &p[i]);
            int foot = side ? FOOT + RIGHT_SIDE : FOOT;
            assert_true(fabs(p[0].place[foot].z - p[1].place[foot].z - 0.16 * ground) < 0.002);
            assert_true(fabs(p[0].place[foot].x - p[1].place[foot].x) < 0.002);
        }
    }
}

// ---- volumes ----

// How much of its area a ring of `count` points has in a pose: that of its projection along its mean normal.
static double ring_area(const struct vec3 *points, int count)
{
    struct vec3 center = vec3_make(0, 0, 0), sum = vec3_make(0, 0, 0);
    for (int i = 0; i < count; i++)
        center = vec3_add(center, vec3_scale(points[i], 1.0 / count));
    for (int i = 0; i < count; i++)
        sum =
            vec3_add(sum, vec3_cross(vec3_sub(points[i], center), vec3_sub(points[(i + 1) % count], center)));
    return 0.5 * vec3_length(sum);
}

// A ring around a limb at rest that follows what the cloth there does.
static double kept_area(const struct anatomy *a, const struct pose *p, bool arm, double share)
{
    enum { COUNT = 16 };
    struct vec3 rest[COUNT], now[COUNT];
    const struct vec3 *j = a->skeleton.rest;
    struct vec3 from = j[arm ? UPPER_ARM : UPPER_LEG], to = j[arm ? HAND : FOOT];
    struct vec3 axis = vec3_normalize(vec3_sub(to, from)), side = vec3_make(0, 0, 1);
    struct vec3 up = vec3_normalize(vec3_cross(side, axis));
    side = vec3_cross(axis, up);
    for (int k = 0; k < COUNT; k++) {
        double angle = 2.0 * CONTENT_PI * k / COUNT, radius = arm ? 0.045 : 0.06;
        struct vec3 out =
            vec3_add(vec3_scale(up, radius * cos(angle)), vec3_scale(side, radius * sin(angle)));
        rest[k] = vec3_add(vec3_mix(from, to, share), out);
        struct weights w;
        body_weigh_limb(a, rest[k], arm, &w);
        now[k] = vec3_make(0, 0, 0);
        for (int i = 0; i < PEOPLE_JOINTS; i++)
            now[k] = vec3_add(
                now[k], vec3_scale(vec3_add(p->place[i], quat_rotate(p->world[i], vec3_sub(rest[k], j[i]))),
                                   w.of[i]));
    }
    return ring_area(now, COUNT) / ring_area(rest, COUNT);
}

static void elbows_and_knees_keep_their_volume(void **state)
{
    NG_UNUSED(state);
    struct anatomy a;
    anatomy_make(&(struct build){1, 1, 1, 1, 1, 1, 0, 0, 0}, &a);
    for (int c = 0; c < PEOPLE_CLIPS; c++)
        for (int k = 0; k < people_clips[c].keys; k++) {
            struct pose p;
            people_pose(&a.skeleton, (enum people_clip)c, (double)k / people_clips[c].keys, &p);
            for (double share = 0.40; share < 0.95; share += 0.02) {
                double arm = kept_area(&a, &p, true, share), leg = kept_area(&a, &p, false, share);
                if (arm < 0.6 || leg < 0.6)
                    fail_msg("%s, key %d: of the section at %.2f of the limb is left: arm %.2f, leg %.2f",
                             people_clips[c].name, k, share, arm, leg);
            }
        }
}

static void the_row_is_made_the_same_twice(void **state)
{
    NG_UNUSED(state);
    struct bytes one, two;
    assert_int_equal(people_build(&one), NG_OK);
    assert_int_equal(people_build(&two), NG_OK);
    assert_int_equal(one.count, two.count);
    assert_memory_equal(one.items, two.items, one.count);
    bytes_finish(&one);
    bytes_finish(&two);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(bodies_are_whole),
        cmocka_unit_test(clips_loop_and_have_no_jump),
        cmocka_unit_test(feet_stand_on_the_floor_and_bones_keep_their_length),
        cmocka_unit_test(walking_feet_do_not_slide),
        cmocka_unit_test(elbows_and_knees_keep_their_volume),
        cmocka_unit_test(the_row_is_made_the_same_twice),
    };
    return cmocka_run_group_tests(tests, make_bodies, drop_bodies);
}
