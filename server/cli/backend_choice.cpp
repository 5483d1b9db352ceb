#include "server/cli/backend_choice.h"

#include <utility>

#include "core/error.h"
#include "core/reconstruction/fallback_backend.h"
#include "gpu/egl_context.h"
#include "gpu/gpu_backend.h"

namespace anyrate {
namespace {

BackendChoice on_cpu(std::string sentence) {
    BackendChoice choice;
    choice.factory = make_cpu_backend;
    choice.sentence = std::move(sentence);
    choice.name = [] { return std::string("cpu"); };
    return choice;
}

BackendChoice on_device(std::shared_ptr<EglContext> context, std::function<void(const std::string&)> warn) {
    const auto has_failed = std::make_shared<bool>(false);
    const GraphicsDevice device = context->device();
    const BackendFactory factory = [context = std::move(context)](const PhotoImages& images, Sampling sampling) {
        return make_gpu_backend(context, images, sampling);
    };
    const DeviceFailureFn on_failure = [has_failed, warn = std::move(warn)](const std::string& reason) {
        *has_failed = true;
        warn("the GPU failed (" + reason + "); the CPU goes on");
    };
    return {.factory = with_cpu_fallback(factory, on_failure),
            .device = device.renderer,
            .is_hardware = !device.is_software,
            .sentence = "computing on " + device.renderer,
            .name = [has_failed] { return std::string(*has_failed ? "gpu, then cpu" : "gpu"); }};
}

}  // namespace

const std::map<std::string, BackendKind>& backend_kinds() {
    static const std::map<std::string, BackendKind> kinds = {
        {"auto", BackendKind::automatic}, {"cpu", BackendKind::cpu}, {"gpu", BackendKind::gpu}};
    return kinds;
}

BackendChoice choose_backend(BackendKind kind, std::function<void(const std::string&)> warn) {
    if (kind == BackendKind::cpu) return on_cpu("computing on the CPU");
    try {
        const auto devices = kind == BackendKind::gpu ? DeviceChoice::any : DeviceChoice::hardware;
        return on_device(std::make_shared<EglContext>(devices), std::move(warn));
    } catch (const DeviceError& error) {
        if (kind == BackendKind::gpu) throw DeviceError(std::string("--backend gpu: ") + error.what());
        return on_cpu(std::string("computing on the CPU: ") + error.what());
    }
}

}  // namespace anyrate
