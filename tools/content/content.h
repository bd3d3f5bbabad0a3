// What tools/content makes: every file of content/, each by one function.
#ifndef CONTENT_CONTENT_H
#define CONTENT_CONTENT_H

#include "image.h"

struct content_file {
    const char *path; // below content/
    ng_result (*build)(struct bytes *out);
};

// All files; ends with a null path.
extern const struct content_file content_files[];

// Builds one file. On failure one line names it, and `out` is empty.
NG_NODISCARD ng_result content_build(const struct content_file *file, struct bytes *out);

// The scenes, by source file.
// chess.c: Chess; its dance from a camera that flies; and with something that training on it never shows.
NG_NODISCARD ng_result chess_build(struct bytes *out);
NG_NODISCARD ng_result chess_flight(struct bytes *out);
NG_NODISCARD ng_result unseen_knots(struct bytes *out);
NG_NODISCARD ng_result unseen_figures(struct bytes *out);
NG_NODISCARD ng_result unseen_lights(struct bytes *out);
NG_NODISCARD ng_result unseen_wall(struct bytes *out);
#define CHESS_PIECE_LEVEL 2 // to which the pieces are refined: 336,000 triangles in all

// unit_lights.c
NG_NODISCARD ng_result unit_light_point(struct bytes *out);
NG_NODISCARD ng_result unit_light_spot(struct bytes *out);
NG_NODISCARD ng_result unit_light_directional(struct bytes *out);
NG_NODISCARD ng_result unit_light_rectangle(struct bytes *out);
NG_NODISCARD ng_result unit_light_rectangle_textured(struct bytes *out);
NG_NODISCARD ng_result unit_light_disk(struct bytes *out);
NG_NODISCARD ng_result unit_light_sphere(struct bytes *out);
NG_NODISCARD ng_result unit_light_mesh(struct bytes *out);
NG_NODISCARD ng_result unit_light_environment(struct bytes *out);
NG_NODISCARD ng_result unit_environment_hdr(struct bytes *out);

// unit_features.c
NG_NODISCARD ng_result unit_materials(struct bytes *out);
NG_NODISCARD ng_result unit_alpha_mask(struct bytes *out);
NG_NODISCARD ng_result unit_normal_map(struct bytes *out);
NG_NODISCARD ng_result unit_textures(struct bytes *out);
NG_NODISCARD ng_result unit_double_sided(struct bytes *out);
NG_NODISCARD ng_result unit_accessors(struct bytes *out);
NG_NODISCARD ng_result unit_interpolation(struct bytes *out);
NG_NODISCARD ng_result unit_animated_fields(struct bytes *out);
NG_NODISCARD ng_result unit_subdivision(struct bytes *out);
NG_NODISCARD ng_result unit_mirrored(struct bytes *out);
NG_NODISCARD ng_result unit_hierarchy(struct bytes *out);

// character.c
NG_NODISCARD ng_result unit_character(struct bytes *out);

#endif
