// Irradiance of an emitter's facets in closed form, for receivers so near that VPLs, which are points, show one by one.

// Lambert's formula: twice the irradiance of a polygon of unit radiance is the sum over its edges of the angle under which
// an edge is seen, times the cosine between n and the normal of the plane through the edge and the receiver.
float edge_share(vec3 a, vec3 b, vec3 n)
{
    vec3 c = cross(a, b);
    float sine = length(c);
    return sine > 0 ? dot(c, n) / sine * atan(sine, dot(a, b)) : 0;
}

// The same of an edge's part above the receiver's horizon. Where it passes the horizon it leaves a point behind.
float upper_edge_share(vec3 a, vec3 b, vec3 n, inout vec3 rise, inout vec3 set)
{
    float above_a = dot(a, n), above_b = dot(b, n);
    if (above_a <= 0 && above_b <= 0)
        return 0;
    vec3 middle = mix(a, b, clamp(above_a / (above_a - above_b), 0.0, 1.0));
    if (above_a <= 0)
        a = rise = middle;
    else if (above_b <= 0)
        b = set = middle;
    return edge_share(a, b, n);
}

// Of unit radiance; corners relative to the receiver.
float triangle_irradiance(vec3 a, vec3 b, vec3 c, vec3 n)
{
    vec3 rise = vec3(0), set = vec3(0);
    float sum = upper_edge_share(a, b, n, rise, set) + upper_edge_share(b, c, n, rise, set) +
                upper_edge_share(c, a, n, rise, set);
    return 0.5 * abs(sum + edge_share(set, rise, n));
}

const float SKIN = 1e-4; // in edges of a facet: as rounding lifts the emitter's own pixels from their plane
// From afar a triangle is a point.
const float FAR_TRIANGLE = 4; // square of its distance over that of its longest edge

float facet_irradiance(vec3 a, vec3 b, vec3 c, vec3 n)
{
    vec3 ab = b - a, ac = c - a, bc = c - b, middle = (a + b + c) / 3;
    vec3 twice_area = cross(ab, ac);
    float height = -dot(a, twice_area); // of the receiver on the side that shines, times twice the area
    float square = dot(middle, middle), longest = max(dot(ab, ab), max(dot(ac, ac), dot(bc, bc)));
    bool inside = abs(height) <= SKIN * sqrt(longest) * length(twice_area); // the receiver lies in its plane
    if (inside || height < 0 && light.facet_kind == NG_FACETS_ONE_SIDED)
        return 0;
    if (square > FAR_TRIANGLE * longest)
        return 0.5 * abs(height) * max(dot(middle, n), 0.0) / (square * square);
    return triangle_irradiance(a, b, c, n);
}

// Of a ball of unit radiance, the part above the horizon (Snyder 1996, "Area light sources for real-time graphics").
float ball_irradiance(vec3 center, float radius, vec3 n)
{
    float ratio = max(dot(center, center) / (radius * radius), 1.0001), cosine = dot(normalize(center), n);
    if (cosine > 0 && cosine * cosine * ratio > 1)
        return NG_SHADER_PI * cosine / ratio;
    float sine = sqrt(max(1 - cosine * cosine, 1e-8)), x = sqrt(ratio - 1), y = -x * cosine / sine;
    float rim = sine * sqrt(max(1 - y * y, 0.0));
    return y < 1 ? max((cosine * acos(clamp(y, -1.0, 1.0)) - x * rim) / ratio + atan(rim / x), 0.0) : 0;
}

// Of a small patch of unit radiance, of which the shape is not known. Seen from nearer than patches lie apart it moves
// back behind the surface: there all of them together are as even as the surface that they stand for.
float patch_irradiance(vec3 center, vec3 normal, float area, vec3 n)
{
    const float WIDE = 2; // square of how far it moves, over its area
    float height = max(-dot(center, normal), 0.0), near = dot(center, center) / (9 * WIDE * area);
    float higher = sqrt(height * height + WIDE * area / (1 + near * near));
    vec3 to = center - normal * (higher - height);
    float square = dot(to, to);
    bool seen = height > SKIN * sqrt(area) && dot(center, n) > 0; // where it is, not where it moves to
    return seen ? area * higher * max(dot(to, n), 0.0) / (square * square) : 0;
}

// Of the whole emitter, nothing in between. Loops that have nothing to do cost nothing; branches do, where a CPU takes
// the place of a GPU, since all that may be done is done there.
vec3 near_irradiance(vec3 p, vec3 n, bool wanted)
{
    vec3 sum = vec3(0);
    uint kind = light.facet_kind, count = wanted ? light.facet_count : 0;
    for (uint i = 0, end = kind <= NG_FACETS_TWO_SIDED ? count : 0; i < end; i++)
        sum += facets[i].radiance *
               facet_irradiance(facets[i].corners[0] - p, facets[i].corners[1] - p, facets[i].corners[2] - p, n);
    for (uint i = 0, end = kind == NG_FACETS_PATCHES ? count : 0; i < end; i++)
        sum += facets[i].radiance *
               patch_irradiance(facets[i].corners[0] - p, facets[i].corners[1], facets[i].corners[2].x, n);
    if (kind == NG_FACETS_BALL && wanted)
        sum = facets[0].radiance * ball_irradiance(facets[0].corners[0] - p, facets[0].corners[1].x, n);
    return sum;
}
