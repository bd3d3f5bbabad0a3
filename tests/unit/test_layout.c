// Structs of shaders/shared/scene.h: the offsets that C gives them are those in the SPIR-V.
#include "test.h"

#include "shaders/shared/scene.h"

#include "direct.frag.spv.h"
#include "gbuffer_plain.frag.spv.h"
#include "observe_plain.frag.spv.h"

#include <stdbool.h>

struct member {
    const char *type, *name;
    uint32_t offset;
};

#define M(type, name)                                                                                        \
    {                                                                                                        \
#type, #name, offsetof(struct type, name)                                                            \
    }
static const struct member members[] = {
    M(ng_view_data, view_projection),
    M(ng_view_data, previous_view_projection),
    M(ng_view_data, right),
    M(ng_view_data, down),
    M(ng_view_data, forward),
    M(ng_view_data, position),
    M(ng_view_data, near_plane),
    M(ng_view_data, size),
    M(ng_instance_data, matrix),
    M(ng_instance_data, previous_matrix),
    M(ng_instance_data, material),
    M(ng_instance_data, entity),
    M(ng_instance_data, flags),
    M(ng_material_data, base_color),
    M(ng_material_data, metallic),
    M(ng_material_data, emission),
    M(ng_material_data, roughness),
    M(ng_material_data, normal_scale),
    M(ng_material_data, alpha),
    M(ng_material_data, alpha_cutoff),
    M(ng_material_data, flags),
    M(ng_material_data, specular_color),
    M(ng_material_data, specular),
    M(ng_material_data, uv_rows),
    M(ng_light_view_data, view_projection),
    M(ng_light_view_data, axis_x),
    M(ng_light_view_data, tangent),
    M(ng_light_view_data, axis_y),
    M(ng_light_view_data, depth_range),
    M(ng_light_view_data, axis_z),
    M(ng_light_view_data, origin),
    M(ng_light_data, proxy),
    M(ng_light_data, layers),
    M(ng_light_data, look),
    M(ng_light_data, tangent),
    M(ng_light_data, right),
    M(ng_light_data, depth_range),
    M(ng_light_data, up),
    M(ng_light_data, face_size),
    M(ng_light_data, windows),
    M(ng_light_data, window_count),
    M(ng_light_data, soft_radius),
    M(ng_light_data, soft_normal),
    M(ng_light_data, cone_scale),
    M(ng_light_data, cone_offset),
    M(ng_light_data, vpl_kind),
    M(ng_light_data, vpl_count),
    M(ng_light_data, vpl_radius),
    M(ng_light_data, index),
    M(ng_light_data, facet_kind),
    M(ng_light_data, facet_count),
    M(ng_vpl_data, position),
    M(ng_vpl_data, normal),
    M(ng_vpl_data, weight),
    M(ng_vpl_data, density),
    M(ng_facet_data, corners),
    M(ng_facet_data, radiance),
};

// Instructions of the SPIR-V specification, 3.32, and the decoration Offset.
enum { OP_NAME = 5, OP_MEMBER_NAME = 6, OP_MEMBER_DECORATE = 72, DECORATION_OFFSET = 35 };

struct module {
    const uint32_t *words;
    size_t count;
};

// Finds the next instruction `op` from `at` on; 0 at the end.
static size_t next(const struct module *m, size_t at, uint32_t op)
{
    while (at < m->count) {
        if ((m->words[at] & 0xffff) == op)
            return at;
        at += m->words[at] >> 16;
    }
    return 0;
}

static size_t after(const struct module *m, size_t at)
{
    return at + (m->words[at] >> 16);
}

// Type ids can be several: one for each block layout that the struct is used in. True if `type` has the name.
static bool is_called(const struct module *m, uint32_t type, const char *name)
{
    for (size_t at = 5; (at = next(m, at, OP_NAME)); at = after(m, at))
        if (m->words[at + 1] == type)
            return strcmp((const char *)&m->words[at + 2], name) == 0;
    return false;
}

static bool member_is_called(const struct module *m, uint32_t type, uint32_t index, const char *name)
{
    for (size_t at = 5; (at = next(m, at, OP_MEMBER_NAME)); at = after(m, at))
        if (m->words[at + 1] == type && m->words[at + 2] == index)
            return strcmp((const char *)&m->words[at + 3], name) == 0;
    return false;
}

// How often the member's offset is stated in the module; each statement must agree.
static int check_member(const struct module *m, const struct member *member)
{
    int found = 0;
    for (size_t at = 5; (at = next(m, at, OP_MEMBER_DECORATE)); at = after(m, at)) {
        uint32_t type = m->words[at + 1], index = m->words[at + 2];
        if (m->words[at + 3] != DECORATION_OFFSET || !is_called(m, type, member->type) ||
            !member_is_called(m, type, index, member->name))
            continue;
        if (m->words[at + 4] != member->offset)
            fail_msg("%s.%s is at %u in SPIR-V, at %u in C", member->type, member->name, m->words[at + 4],
                     member->offset);
        found++;
    }
    return found;
}

static void offsets_agree(void **state)
{
    NG_UNUSED(state);
    const struct module modules[] = {
        {ng_spv_direct_frag, NG_COUNT(ng_spv_direct_frag)},
        {ng_spv_gbuffer_plain_frag, NG_COUNT(ng_spv_gbuffer_plain_frag)},
        {ng_spv_observe_plain_frag, NG_COUNT(ng_spv_observe_plain_frag)},
    };
    for (size_t i = 0; i < NG_COUNT(members); i++) {
        int found = 0;
        for (size_t k = 0; k < NG_COUNT(modules); k++)
            found += check_member(&modules[k], &members[i]);
        if (!found)
            fail_msg("%s.%s is in no shader", members[i].type, members[i].name);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(offsets_agree)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
