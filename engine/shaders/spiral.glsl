// The next direction of Vogel's spiral: a turn by the golden angle. With radius sqrt((i + 0.5) / count) its points are
// spread evenly over a disk.
vec2 next_turn(vec2 turn)
{
    const vec2 golden = vec2(-0.73736888, 0.67549029);
    return vec2(turn.x * golden.x - turn.y * golden.y, turn.x * golden.y + turn.y * golden.x);
}
