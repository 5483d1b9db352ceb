#include "server/cli/output_name.h"

#include <CLI/CLI.hpp>

#include "core/error.h"
#include "core/mesh/mesh_io.h"

namespace anyrate {

CLI::Validator mesh_file_name() {
    return CLI::Validator(
        [](const std::string& name) -> std::string {
            try {
                mesh_format(name);
                return {};
            } catch (const InputError& error) {
                return error.what();
            }
        },
        "FILE.(ply|obj|glb)", "mesh file name");
}

}  // namespace anyrate
