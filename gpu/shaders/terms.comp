// Photo-consistency of a batch of triangles: phi and its samples (Nghiem et al., Eqs. 5-8), and WITH_DERIVATIVES those of
// add_terms() (sample_lanes.h). LANES invocations share a triangle, each taking every LANES-th sample of its lattice, so
// that the order of every sum is fixed; reduce.comp adds them up.
//
// A sample's mean over its views is not known until the last of them has been seen, and nothing of a view is kept.
// Instead all is summed as its difference from the first view, which costs no more than a factor of the number of views
// in precision: sum (c - mean)^2 = sum (c - c0)^2 - K (mean - c0)^2, whose first term is at most K + 1 times the whole.
layout(local_size_x = 64) in;
layout(std430, binding = 0) readonly buffer Queries { Query queries[]; };
layout(std430, binding = 1) readonly buffer Faces { Face faces[]; };
layout(std430, binding = 2) readonly buffer Pairs { Pair pairs[]; };
layout(std430, binding = 3) readonly buffer Lattices { vec4 lattices[]; };  // two a sample, all numbers of steps in turn
layout(std430, binding = 4) readonly buffer Triangles { int triangles[]; };
layout(std430, binding = 5) readonly buffer Weights { float corner_weights[]; };  // 1 / valence of each vertex
layout(std430, binding = 6) writeonly buffer Partials { float partials[]; };
layout(binding = 0) uniform usampler2DArray photographs;  // red, green, blue, alpha from the lowest byte on
layout(binding = 1) uniform usampler2DArray inverse_depth;
layout(location = 0) uniform int first_query;
layout(location = 1) uniform int n_queries;
layout(location = 2) uniform int n_views;
layout(location = 3) uniform int level;
layout(location = 4) uniform float level_scale;  // pixels of level 0 in one of this level
layout(location = 5) uniform float depth_scale;  // pixels of the depth map in one of level 0
layout(std430, binding = 7) readonly buffer Sizes { int depth_sizes[]; };  // see DepthMaps

vec3 colour(uint rgba) { return vec3(rgba & 255u, (rgba >> 8) & 255u, (rgba >> 16) & 255u); }

// Whether a point of a face that a view sees in part is in front of everything else (Visibility::is_visible()).
bool is_visible(int view, vec2 pixel, float inverse_z, float slope) {
    precise vec2 on_photograph = (pixel + 0.5) * level_scale - 0.5;
    precise vec2 on_map = (on_photograph + 0.5) * depth_scale - 0.5;
    const ivec2 size = ivec2(depth_sizes[2 * view], depth_sizes[2 * view + 1]);
    if (!is_on_map(vec3(on_map, 1), vec2(size - 1))) return false;
    precise float nearer = inverse_z * (1.0 + slope);
    const float far_part = intBitsToFloat(depth_sizes[2 * n_views + view]);
    return nearer >= nearest_around(inverse_depth, view, on_map, size, far_part);
}

void main() {
    const int item = int(gl_GlobalInvocationID.x) / LANES, lane = int(gl_GlobalInvocationID.x) % LANES;
    if (item >= n_queries) return;
    const int f = queries[first_query + item].face;
    const int n_seeing = faces[f].n_views, M = faces[f].steps;
    const float slope = faces[f].slope;
    const vec3 corner_weight = vec3(corner_weights[triangles[3 * f]], corner_weights[triangles[3 * f + 1]],
                                    corner_weights[triangles[3 * f + 2]]);
    float phi = 0, n_samples = 0;
#if WITH_DERIVATIVES
    vec3 gradient = vec3(0), hessian_own = vec3(0), hessian_next = vec3(0), middle_gradient = vec3(0),
         middle_hessian = vec3(0);
#endif
    const int first_sample = M * (M + 1) * (M + 2) / 6 - 1;
    const int n_lattice = n_seeing < 2 ? 0 : (M + 1) * (M + 2) / 2;
    for (int s = lane; s < n_lattice; s += LANES) {
        const vec4 b = lattices[2 * (first_sample + s)], middle = lattices[2 * (first_sample + s) + 1];
        float n = 0, sum_dd = 0;
        vec3 c0 = vec3(0), sum_d = vec3(0);
#if WITH_DERIVATIVES
        float sum_qq = 0;
        vec3 q0 = vec3(0), sum_q = vec3(0), sum_dg = vec3(0), sum_g[3] = vec3[3](vec3(0), vec3(0), vec3(0));
#endif
        for (int k = 0; k < n_seeing; ++k) {
            const int at = item * n_views + k;
            const float z = b.x * pairs[at].corner_z[0] + b.y * pairs[at].corner_z[1] + b.z * pairs[at].corner_z[2];
            const float inverse_z = 1.0 / z;
            const vec2 p = vec2(b.x * pairs[at].corner_x[0] + b.y * pairs[at].corner_x[1] + b.z * pairs[at].corner_x[2],
                                b.x * pairs[at].corner_y[0] + b.y * pairs[at].corner_y[1] + b.z * pairs[at].corner_y[2]) *
                           inverse_z;
            if (!(inverse_z > 0 && p.x >= 0 && p.y >= 0 && p.x < pairs[at].width && p.y < pairs[at].height)) continue;
            const int sight = pairs[at].sight, view = sight >> 1;
            const ivec2 origin = ivec2(pairs[at].x, pairs[at].y);
            const ivec3 texel = ivec3(origin + ivec2(p), view);
            const uint top_left = texelFetch(photographs, texel, level).r,
                       top_right = texelFetch(photographs, texel + ivec3(1, 0, 0), level).r,
                       bottom_left = texelFetch(photographs, texel + ivec3(0, 1, 0), level).r,
                       bottom_right = texelFetch(photographs, texel + ivec3(1, 1, 0), level).r;
            if ((top_left & top_right & bottom_left & bottom_right) < 0xff000000u) continue;  // not the object's alone
            if ((sight & 1) == 0 && !is_visible(view, vec2(origin) + p, inverse_z, slope)) continue;

            const vec2 uv = p - trunc(p);
            const vec3 A = colour(top_left), B = colour(top_right), C = colour(bottom_left), D = colour(bottom_right);
            const vec3 left = C - A, right = D - B, on_left = A + uv.y * left;
            const vec3 c = on_left + uv.x * ((B + uv.y * right) - on_left);
            if (n == 0) c0 = c;
            const vec3 d = c - c0;
            sum_d += d;
            sum_dd += dot(d, d);
#if WITH_DERIVATIVES
            const vec3 by_x = (B - A) + uv.y * (right - left), by_y = left + uv.x * (right - left);
            vec3 q = vec3(0);
            for (int a = 0; a < 3; ++a) {
                // The derivative of the projection along the direction of the corner, then that of the colour.
                const float u = (pairs[at].motion_x[a] - p.x * pairs[at].motion_z[a]) * inverse_z;
                const float v = (pairs[at].motion_y[a] - p.y * pairs[at].motion_z[a]) * inverse_z;
                const vec3 g = u * by_x + v * by_y;
                sum_dg[a] += dot(d, g);
                sum_g[a] += g;
                q += b[a] * g;
            }
            if (n == 0) q0 = q;
            q -= q0;
            sum_q += q;
            sum_qq += dot(q, q);
#endif
            n += 1;
        }
        if (n < 2) continue;
        const vec3 mean = sum_d / n;
        const float weight = b.w + (middle.w >= 0 ? corner_weight[int(middle.w)] : 0.0);
        const float scale = weight / (n - 1);
        // Nghiem et al., Eq. 5.
        phi += scale * max(sum_dd - dot(sum_d, mean), 0.0);
        n_samples += weight;
#if WITH_DERIVATIVES
        const float curvature = 2 * scale * max(sum_qq - dot(sum_q, sum_q) / n, 0.0);
        const vec3 along = sum_dg - vec3(dot(mean, sum_g[0]), dot(mean, sum_g[1]), dot(mean, sum_g[2]));
        const float slope_along = 2 * scale * dot(b.xyz, along);
        gradient += 2 * scale * b.xyz * along;
        hessian_own += curvature * b.xyz * b.xyz;
        hessian_next += curvature * b.xyz * b.yzx;
        middle_gradient += slope_along * middle.xyz;
        middle_hessian += curvature * middle.xyz * middle.xyz;
#endif
    }
    const int out_at = (item * LANES + lane) * N_TERMS;
    partials[out_at] = phi;
    partials[out_at + 1] = n_samples;
#if WITH_DERIVATIVES
    for (int a = 0; a < 3; ++a) {
        partials[out_at + 2 + a] = gradient[a];
        partials[out_at + 5 + a] = hessian_own[a];
        partials[out_at + 8 + a] = hessian_next[a];
        partials[out_at + 11 + a] = middle_gradient[a];
        partials[out_at + 14 + a] = middle_hessian[a];
    }
#endif
}
