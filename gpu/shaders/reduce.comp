// Adds up what the invocations that share a triangle found, always in the same order.
layout(local_size_x = 64) in;
layout(std430, binding = 0) readonly buffer Partials { float partials[]; };
layout(std430, binding = 1) writeonly buffer Results { float results[]; };
layout(location = 0) uniform int first_query;
layout(location = 1) uniform int n_queries;

void main() {
    const int i = int(gl_GlobalInvocationID.x);
    if (i >= n_queries * N_TERMS) return;
    const int item = i / N_TERMS, term = i % N_TERMS;
    double sum = 0;
    for (int lane = 0; lane < LANES; ++lane) sum += double(partials[(item * LANES + lane) * N_TERMS + term]);
    results[first_query * N_TERMS + i] = float(sum);
}
