// For a work group that has all of a round's vertices to itself, so that its invocations can wait for each other.
layout(local_size_x = WORKERS) in;
int worker = int(gl_LocalInvocationID.x);

shared double shares[WORKERS];

// The sum of what all have, always taken in the same order. All must call it.
double total(double share) {
    barrier();
    shares[worker] = share;
    for (int n = WORKERS / 2; n > 0; n /= 2) {
        memoryBarrierShared();
        barrier();
        if (worker < n) shares[worker] += shares[worker + n];
    }
    memoryBarrierShared();
    barrier();
    return shares[0];
}

// What each has written so far is there for all. All must call it.
void meet() {
    memoryBarrierBuffer();
    barrier();
}
