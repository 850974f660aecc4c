"""Programs of the graphics card for the 3D view, in GLSL 3.30."""

# Bodies; with ``flat_share`` 1 their shadows, cast on the ground along the light.
BODY = """#version 330 core
layout(location=0) in vec3 place; layout(location=1) in vec3 normal;
layout(location=2) in vec3 colour; layout(location=3) in float own;
layout(location=4) in vec4 row_x; layout(location=5) in vec4 row_y; layout(location=6) in vec4 row_z;
layout(location=7) in vec3 shade;
uniform mat4 camera; uniform vec3 light; uniform float flat_share;
out vec3 hue; out vec3 facing; out vec3 at;
void main() {
    vec4 local = vec4(place, 1.0);
    vec3 world = vec3(dot(row_x, local), dot(row_y, local), dot(row_z, local));
    facing = vec3(dot(row_x.xyz, normal), dot(row_y.xyz, normal), dot(row_z.xyz, normal));
    float bright = dot(shade, vec3(1.0));
    vec3 arrow = bright < 1.5 ? vec3(0.95) : vec3(0.12);
    hue = own < 0.0 ? arrow : mix(colour, shade, own);
    vec3 fallen = vec3(world.xy - light.xy / light.z * max(world.z, 0.0), 0.003);
    at = mix(world, fallen, flat_share);
    gl_Position = camera * vec4(at, 1.0);
}"""
LIT = """#version 330 core
in vec3 hue; in vec3 facing; in vec3 at; out vec4 colour;
uniform vec3 light; uniform vec3 eye; uniform float flat_share; uniform float dark;
uniform float opacity;
void main() {
    if (flat_share > 0.5) { colour = vec4(0.0, 0.0, 0.0, dark); return; }
    vec3 n = normalize(facing);
    vec3 middle = normalize(light + normalize(eye - at));
    float diffuse = max(dot(n, light), 0.0), sky = 0.5 + 0.5 * n.z;
    float gleam = 0.18 * pow(max(dot(n, middle), 0.0), 24.0);
    vec3 base = 0.06 + 0.94 * hue;
    colour = vec4(base * (0.40 + 0.18 * sky + 0.52 * diffuse) + gleam, opacity);
}"""
# One large triangle: the ground where a ray from the eye meets it, else the sky.
RAY = """#version 330 core
uniform mat3 axes; uniform vec2 slope; out vec3 ray;
void main() {
    vec2 corner = vec2((gl_VertexID << 1) & 2, gl_VertexID & 2) * 2.0 - 1.0;
    ray = axes * vec3(corner * slope, 1.0);
    gl_Position = vec4(corner, 1.0, 1.0);
}"""
SURROUNDINGS = """#version 330 core
in vec3 ray; out vec4 colour;
uniform vec3 eye; uniform vec3 ground; uniform vec3 sky; uniform vec3 lines;
uniform float wide; uniform float reach; uniform float strength;
float line(float value) {
    float width = fwidth(value);
    return 1.0 - smoothstep(0.3, 1.1, abs(fract(value - 0.5) - 0.5) / max(width, 1e-6));
}
void main() {
    vec3 zenith = mix(sky, vec3(0.45, 0.62, 0.82) * dot(sky, vec3(0.4)), 0.55);
    vec3 way = normalize(ray);
    vec3 horizon = sky;
    if (way.z >= 0.0) { colour = vec4(mix(horizon, zenith, sqrt(way.z)), 1.0); return; }
    vec3 at = eye - ray * (eye.z / ray.z);
    float away = length(at - eye);
    vec2 place = at.xy / wide;
    float grid = max(line(place.x), line(place.y)) * strength * exp(-away / reach);
    vec3 floor_hue = mix(ground, lines, grid);
    colour = vec4(mix(horizon, floor_hue, exp(-away / (6.0 * reach))), 1.0);
}"""
PATH = """#version 330 core
layout(location=0) in vec3 place; layout(location=1) in vec4 hue;
uniform mat4 camera; out vec4 shade;
void main() { shade = hue; gl_Position = camera * vec4(place, 1.0); }"""
# Lines are one pixel wide on most drivers: each is made a strip of two triangles.
WIDEN = """#version 330 core
layout(lines) in; layout(triangle_strip, max_vertices=4) out;
in vec4 shade[]; out vec4 hue; uniform vec2 pixel; uniform float wide;
void main() {
    vec4 a = gl_in[0].gl_Position, b = gl_in[1].gl_Position;
    if (a.w <= 0.0 || b.w <= 0.0) return;
    vec2 along = (b.xy / b.w - a.xy / a.w) / pixel;
    vec2 side = normalize(vec2(-along.y, along.x) + 1e-9) * pixel * 0.5 * wide;
    hue = shade[0];
    gl_Position = a + vec4(side * a.w, 0.0, 0.0); EmitVertex();
    gl_Position = a - vec4(side * a.w, 0.0, 0.0); EmitVertex();
    gl_Position = b + vec4(side * b.w, 0.0, 0.0); EmitVertex();
    gl_Position = b - vec4(side * b.w, 0.0, 0.0); EmitVertex();
    EndPrimitive();
}"""
PLAIN = """#version 330 core
in vec4 hue; out vec4 colour;
void main() { colour = hue; }"""
