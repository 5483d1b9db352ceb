#pragma once
#include <cstdint>
#include <string>
#include <string_view>

namespace anyrate {

/// A fresh name of a model: 128 random bits of the kernel as 26 letters and digits (base 32, a-z2-7), so that nobody
/// guesses one and it is safe as the name of a folder. @throws IoError the kernel gave no randomness
std::string new_model_id();

/// Whether somebody's text is shaped like a model id. Only such texts ever become part of a path.
bool is_model_id(std::string_view text);

/// The id of a model's log: equal for equal arguments. The same for every attempt that goes on with the log; another
/// for one that begins it anew with other bytes, so that a client can tell.
/// @param generation  1 at first
std::uint64_t log_id_of(std::string_view model_id, std::uint64_t generation);

}  // namespace anyrate
