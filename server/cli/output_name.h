#pragma once

namespace CLI {
class Validator;
}

namespace anyrate {

/// Accepts a file name whose extension is a mesh format that can be written; anything else is wrong usage.
CLI::Validator mesh_file_name();

}  // namespace anyrate
