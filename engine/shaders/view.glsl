// From where the camera of `view` sees a surface (render/camera.h). Orthographic cameras have a range.

// Not of unit length.
vec3 to_eye(vec3 position)
{
    return view.range > 0 ? -view.forward : view.position - position;
}

// In metres; orthographic: from which a usual lens would see as much.
float eye_distance(vec3 position)
{
    return view.range > 0 ? length(view.down) / 0.365 : length(view.position - position);
}
