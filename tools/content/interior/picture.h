// Pictures of the materials of furniture. All tile, but for those of leaves, prints and spines.
//
// The grain of wood and the folds of cloth run along v. Normals are tangent-space, roughness is in G.
#ifndef CONTENT_PICTURE_H
#define CONTENT_PICTURE_H

#include "../image.h"

NG_NODISCARD ng_result picture_oak(struct bytes *out);
NG_NODISCARD ng_result picture_walnut(struct bytes *out);
NG_NODISCARD ng_result picture_wood_relief(struct bytes *out);
NG_NODISCARD ng_result picture_wood_roughness(struct bytes *out);
NG_NODISCARD ng_result picture_weave(struct bytes *out); // near white: the material gives the colour
NG_NODISCARD ng_result picture_weave_relief(struct bytes *out);
NG_NODISCARD ng_result picture_leather_relief(struct bytes *out);
NG_NODISCARD ng_result picture_marble(struct bytes *out);
NG_NODISCARD ng_result picture_wicker(struct bytes *out);
NG_NODISCARD ng_result picture_wicker_relief(struct bytes *out);
NG_NODISCARD ng_result picture_rug(struct bytes *out);
NG_NODISCARD ng_result picture_round_rug(struct bytes *out);
NG_NODISCARD ng_result picture_spines(struct bytes *out); // 16 books side by side
NG_NODISCARD ng_result picture_print_sun(struct bytes *out);
NG_NODISCARD ng_result picture_print_arches(struct bytes *out);
NG_NODISCARD ng_result picture_print_leaves(struct bytes *out);
NG_NODISCARD ng_result picture_screen(struct bytes *out); // what is on television
NG_NODISCARD ng_result picture_shade(struct bytes *out);  // how a lampshade glows, v upwards
NG_NODISCARD ng_result picture_lantern(struct bytes *out);
NG_NODISCARD ng_result picture_clock(struct bytes *out);
// With alpha; the stem is at the bottom, in the middle.
NG_NODISCARD ng_result picture_monstera(struct bytes *out);
NG_NODISCARD ng_result picture_fiddle_leaf(struct bytes *out);
NG_NODISCARD ng_result picture_frond(struct bytes *out);
// Of the room.
NG_NODISCARD ng_result picture_parquet(struct bytes *out);
NG_NODISCARD ng_result picture_parquet_relief(struct bytes *out);
NG_NODISCARD ng_result picture_parquet_roughness(struct bytes *out);
NG_NODISCARD ng_result picture_plaster_relief(struct bytes *out);
NG_NODISCARD ng_result picture_evening(struct bytes *out); // a sky, in Radiance HDR

#endif
