#include "place.h"

struct place place_turn(struct place p, char axis, double angle)
{
    double c = cos(angle), s = sin(angle);
    struct vec3 x = p.x, y = p.y, z = p.z;
    if (axis == 'x') {
        p.y = vec3_add(vec3_scale(y, c), vec3_scale(z, s));
        p.z = vec3_sub(vec3_scale(z, c), vec3_scale(y, s));
    } else if (axis == 'y') {
        p.z = vec3_add(vec3_scale(z, c), vec3_scale(x, s));
        p.x = vec3_sub(vec3_scale(x, c), vec3_scale(z, s));
    } else {
        p.x = vec3_add(vec3_scale(x, c), vec3_scale(y, s));
        p.y = vec3_sub(vec3_scale(y, c), vec3_scale(x, s));
    }
    return p;
}

struct place place_move(struct place p, double x, double y, double z)
{
    p.at = place_point(&p, vec3_make(x, y, z));
    return p;
}

// Of the four squares the largest is divided by, so that nothing cancels.
void place_quaternion(const struct place *p, double out[4])
{
    const double m[3][3] = {{p->x.x, p->y.x, p->z.x}, {p->x.y, p->y.y, p->z.y}, {p->x.z, p->y.z, p->z.z}};
    double square[4] = {1 + m[0][0] - m[1][1] - m[2][2], 1 - m[0][0] + m[1][1] - m[2][2],
                        1 - m[0][0] - m[1][1] + m[2][2], 1 + m[0][0] + m[1][1] + m[2][2]};
    int most = 3;
    for (int i = 0; i < 3; i++)
        if (square[i] > square[most])
            most = i;
    double half = 0.5 / sqrt(square[most]);
    out[most] = 0.5 * sqrt(square[most]);
    for (int i = 0; i < 3; i++) {
        int j = (i + 1) % 3, k = (i + 2) % 3;
        if (most == 3)
            out[i] = (m[k][j] - m[j][k]) * half;
        else if (i != most)
            out[i] = (m[most][i] + m[i][most]) * half;
        else
            out[3] = (m[k][j] - m[j][k]) * half;
    }
}
