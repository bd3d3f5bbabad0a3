#include "content.h"
#include "people/people.h"

#include "base/log.h"
#include "interior/palette.h"
#include "interior/room.h"

#define X(name, where, what)                                                                                 \
    static ng_result build_##name(struct bytes *out)                                                         \
    {                                                                                                        \
        return palette_file(PALETTE_##name, out);                                                            \
    }
PALETTE(X)
#undef X

const struct content_file content_files[] = {
    {"chess/chess.glb", chess_build},
    {"chess/flight.glb", chess_flight},
    {"unseen/knots.glb", unseen_knots},
    {"unseen/figures.glb", unseen_figures},
    {"unseen/lights.glb", unseen_lights},
    {"unseen/wall.glb", unseen_wall},
    {"unit/light_point.glb", unit_light_point},
    {"unit/light_spot.glb", unit_light_spot},
    {"unit/light_directional.glb", unit_light_directional},
    {"unit/light_rectangle.glb", unit_light_rectangle},
    {"unit/light_rectangle_textured.glb", unit_light_rectangle_textured},
    {"unit/light_disk.glb", unit_light_disk},
    {"unit/light_sphere.glb", unit_light_sphere},
    {"unit/light_mesh.glb", unit_light_mesh},
    {"unit/light_environment.glb", unit_light_environment},
    {"unit/materials.glb", unit_materials},
    {"unit/alpha_mask.glb", unit_alpha_mask},
    {"unit/normal_map.glb", unit_normal_map},
    {"unit/textures.glb", unit_textures},
    {"unit/double_sided.glb", unit_double_sided},
    {"unit/accessors.glb", unit_accessors},
    {"unit/interpolation.glb", unit_interpolation},
    {"unit/animated_fields.glb", unit_animated_fields},
    {"unit/subdivision.glb", unit_subdivision},
    {"unit/mirrored.glb", unit_mirrored},
    {"unit/hierarchy.glb", unit_hierarchy},
    {"unit/character.glb", unit_character},
    {"people/people.glb", people_build},
    {"unit/environment.hdr", unit_environment_hdr},
    {"interior_design/room.glb", room_build},
    {"interior_design/evening.hdr", room_sky},
#define X(name, where, what) {"interior_design/" #name ".glb", build_##name},
    PALETTE(X)
#undef X
        {0},
};

ng_result content_build(const struct content_file *file, struct bytes *out)
{
    *out = (struct bytes){0};
    ng_result result = file->build(out);
    if (result != NG_OK) {
        ng_log_error("content/%s was not built: %s", file->path, ng_result_text(result));
        bytes_finish(out);
    }
    return result;
}
