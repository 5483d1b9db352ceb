// cameras.json: whatever the bytes, the result is a camera that keeps Camera's promises, or a fault.
#include <cstdint>
#include <cstdlib>
#include <string_view>

#include "core/capture/cameras_json.h"
#include "core/capture/check_camera.h"
#include "core/error.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    using namespace anyrate;
    Faults faults;
    try {
        const CameraList list = parse_cameras({reinterpret_cast<const char*>(data), size}, "cameras.json", faults);
        for (const CameraEntry& entry : list.entries) {
            const auto camera = to_camera(entry, list.pixel_center, faults);
            if (!camera) continue;
            const bool keeps_promises = camera->K.allFinite() && camera->K(2, 2) == 1.0 && camera->K(0, 0) > 0.0 &&
                                        camera->R.determinant() > 0.99 && camera->t.allFinite();
            if (!keeps_promises) std::abort();
        }
        faults.throw_if_any();
    } catch (const InputError&) {  // a fault was told
    }
    return 0;
}
