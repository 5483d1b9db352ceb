// On whatever device there is; where no GPU is installed that is Mesa's llvmpipe.
#define DOCTEST_CONFIG_IMPLEMENT_WITH_MAIN
#include "gpu/egl_context.h"
#include "gpu/gpu_backend.h"
#include "photo_backend_contract.h"

using namespace anyrate;

TEST_CASE("PhotoBackend contract: the GPU backend keeps it") {
    check_photo_backend(
        [](const PhotoImages& images, Sampling sampling) {
            return make_gpu_backend(std::make_shared<EglContext>(DeviceChoice::any), images, sampling);
        },
        1e-6);
}
