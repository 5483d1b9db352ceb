#include "optimise_round_contract.h"
#include "photo_backend_contract.h"

using namespace anyrate;

TEST_CASE("PhotoBackend contract: the CPU backend keeps it") { check_photo_backend(make_cpu_backend, 1e-12); }

TEST_CASE("PhotoBackend contract: rounds of local optimisation on the CPU backend keep it") {
    check_optimise_round(make_cpu_backend, 0);
}

TEST_CASE("PhotoBackend contract: the CPU backend tells faint images") { check_faintness(make_cpu_backend); }
