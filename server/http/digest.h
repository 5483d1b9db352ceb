#pragma once
#include <optional>

#include "server/http/message.h"
#include "server/store/sha256.h"

namespace anyrate {

/// The SHA-256 that a request says its body has: Content-Digest (RFC 9530, `sha-256=:<base64>:`), or the older Digest
/// (RFC 3230, `SHA-256=<base64>`). nullopt if it says none; other algorithms are passed over.
/// @throws HttpProblem 400 it is not the base64 of 32 bytes
std::optional<Sha256> digest_of_request(const Request& request);

/// @param digest  of the body that came @throws HttpProblem 422 the request says another one
void expect_digest(const Request& request, const Sha256& digest);

}  // namespace anyrate
