#define DOCTEST_CONFIG_IMPLEMENT_WITH_MAIN
#include "photo_backend_contract.h"

using namespace anyrate;

TEST_CASE("PhotoBackend contract: the CPU backend keeps it") { check_photo_backend(make_cpu_backend, 1e-12); }
