#pragma once
#include <span>
#include <string>

#include "server/store/catalog.h"

namespace anyrate {

/// A model as the interface shows it (proto/openapi.yaml, "Model"), with its rate-distortion curve.
std::string model_json(const ModelRecord& model, std::span<const RatePoint> curve);
/// The same without the curve.
std::string model_json(const ModelRecord& model);
/// Of one that was made just now. @param files_json  what was found of the files of its capture, a JSON array
std::string new_model_json(const ModelRecord& model, const std::string& files_json);
/// A page of the list; models without their curves, "next" if there are more.
/// @param limit  models of a page, as it was asked for
std::string model_list_json(const ModelPage& page, std::size_t limit);
/// "2026-01-31T12:00:00.000Z"
std::string iso_time(Timestamp time);

}  // namespace anyrate
