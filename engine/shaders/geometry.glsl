// The geometric normal, which the G-buffer keeps in octahedral form (Meyer et al. 2010) beside the albedos.
vec3 flat_normal(float x, float y)
{
    vec3 n = vec3(x, y, 1 - abs(x) - abs(y));
    float t = max(-n.z, 0.0);
    n.x += n.x >= 0 ? -t : t;
    n.y += n.y >= 0 ? -t : t;
    return normalize(n);
}
