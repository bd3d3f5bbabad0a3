// The plane of flat emitters: the entity's XY plane, wherever its placement puts it.
#include "light/light_internal.h"

bool ng_light_plane_make(const struct ng_light_source *s, float scale_x, float scale_y,
                         struct ng_light_plane *out)
{
    ng_light_scaled(&s->matrix[0], scale_x, out->x);
    ng_light_scaled(&s->matrix[4], scale_y, out->y);
    ng_light_cross(out->x, out->y, out->normal);
    out->area = ng_light_length(out->normal);
    if (!(out->area > 0) || !isfinite(out->area))
        return false;
    // x cross y points along the entity's Z, or against it where the placement mirrors.
    float sign = ng_light_dot(out->normal, &s->matrix[8]) < 0 ? 1.0f : -1.0f;
    ng_light_scaled(out->normal, sign / out->area, out->normal);
    return true;
}

void ng_light_plane_local(const struct ng_light_source *s, const struct ng_light_plane *plane,
                          const float position[3], float local[2])
{
    float p[3];
    ng_light_mad(position, ng_light_origin(s), -1.0f, p);
    // The edges need not be perpendicular (shear): solve the 2 x 2 normal equations.
    float xx = ng_light_dot(plane->x, plane->x), xy = ng_light_dot(plane->x, plane->y);
    float yy = ng_light_dot(plane->y, plane->y), px = ng_light_dot(p, plane->x),
          py = ng_light_dot(p, plane->y);
    float determinant = xx * yy - xy * xy;
    local[0] = (px * yy - py * xy) / determinant;
    local[1] = (py * xx - px * xy) / determinant;
}
