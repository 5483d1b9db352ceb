#include "core/capture/cameras_json.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <nlohmann/json.hpp>
#include <span>
#include <utility>

#include "core/capture/relative_name.h"

namespace anyrate {
namespace {

using Json = nlohmann::json;

/// "line 3, column 7" of the byte with this number, the first being 1, as the parser counts.
std::string line_and_column(std::string_view text, std::size_t byte) {
    const std::string_view before = text.substr(0, std::min(byte == 0 ? 0 : byte - 1, text.size()));
    const auto line = 1 + std::count(before.begin(), before.end(), '\n');
    const std::size_t newline = before.rfind('\n');
    const std::size_t column = before.size() - (newline == std::string_view::npos ? 0 : newline + 1) + 1;
    return "line " + std::to_string(line) + ", column " + std::to_string(column);
}

/// The parser's message without the library's own prefix.
std::string reason(const Json::exception& error) {
    const std::string_view text = error.what();
    const std::size_t end_of_id = text.find("] ");
    return std::string(end_of_id == std::string_view::npos ? text : text.substr(end_of_id + 2));
}

Json parse_json(std::string_view text, const std::string& name) {
    try {
        return Json::parse(text);
    } catch (const Json::parse_error& error) {
        // Many a script writes NaN, which JSON has no word for: say so instead of "invalid literal".
        const std::size_t around = error.byte > 3 ? error.byte - 3 : 0;
        const std::string_view nearby = text.substr(std::min(around, text.size()), 6);
        const bool is_nan =
            nearby.find("NaN") != std::string_view::npos || nearby.find("Inf") != std::string_view::npos;
        throw_fault(name,
                    line_and_column(text, error.byte) + ": " +
                        (is_nan ? "NaN or Infinity; expected finite numbers" : "not JSON (" + reason(error) + ")"));
    } catch (const Json::exception& error) {  // a number beyond double
        throw_fault(name, reason(error) + "; expected finite numbers");
    }
}

/// A value in a few words. Not its text: that may be long, or nested without end.
std::string describe(const Json& value) {
    if (value.is_array()) return "a list of " + std::to_string(value.size());
    if (value.is_object()) return "an object";
    return value.is_string() ? "a string" : value.dump();
}

bool is_finite_number(const Json& value) { return value.is_number() && std::isfinite(value.get<double>()); }

/// Reads exactly numbers.size() finite numbers.
/// @return what is wrong with it, in words; empty if nothing is
std::string read_numbers(const Json& list, std::span<double> numbers) {
    if (!list.is_array() || list.size() != numbers.size()) return describe(list);
    for (std::size_t i = 0; i < numbers.size(); ++i) {
        if (!is_finite_number(list[i])) return describe(list[i]) + " in place " + std::to_string(i);
        numbers[i] = list[i].get<double>();
    }
    return {};
}

/// Reads one entry of the list, field by field, and notes what is wrong with it.
class EntryReader {
public:
    EntryReader(const Json& entry, std::string list_name, const std::string& file_name, Faults& faults)
        : entry_(entry), where_(std::move(list_name)), file_name_(file_name), faults_(faults) {}

    CameraEntry read() {
        CameraEntry result;
        if (entry_.is_object()) {
            result.file = read_name("file", true);
            result.mask = read_name("mask", false);
            result.width = read_size("width");
            result.height = read_size("height");
            result.K = read_matrix("K");
            result.R = read_matrix("R");
            result.t = read_vector("t");
            result.distortion = read_distortion();
        } else {
            fault("it", describe(entry_), "an object with file, K, R and t");
        }
        result.is_well_formed = is_well_formed_;
        return result;
    }

private:
    void fault(const char* field, const std::string& found, const std::string& expected) {
        is_well_formed_ = false;
        faults_.add(file_name_, where_ + ": " + field + " is " + found + "; expected " + expected);
    }

    /// The field's value; nullptr if it is not there, or null.
    const Json* find(const char* field) const {
        const auto member = entry_.find(field);
        return member == entry_.end() || member->is_null() ? nullptr : &*member;
    }

    std::string read_name(const char* field, bool is_required) {
        const Json* value = find(field);
        if (!value) {
            if (is_required) fault(field, "missing", "the name of an image file");
            return {};
        }
        if (!value->is_string()) {
            fault(field, describe(*value), "a file's name");
            return {};
        }
        const auto name = relative_name(value->get_ref<const std::string&>());
        if (!name)
            fault(field, '"' + value->get_ref<const std::string&>() + '"', "a name that stays inside the capture");
        else if (is_required)
            where_ += " (" + *name + ")";
        return name.value_or("");
    }

    std::optional<int> read_size(const char* field) {
        const Json* value = find(field);
        if (!value) return std::nullopt;
        if (value->is_number_integer()) {
            const auto size = value->get<std::int64_t>();
            if (size > 0 && size <= std::numeric_limits<int>::max()) return static_cast<int>(size);
        }
        fault(field, describe(*value), "a positive whole number of pixels");
        return std::nullopt;
    }

    std::optional<Mat3> read_matrix(const char* field) {
        constexpr const char* expected = "3 rows of 3 finite numbers";
        const Json* value = find(field);
        if (!value || !value->is_array() || value->size() != 3) {
            fault(field, value ? describe(*value) : "missing", expected);
            return std::nullopt;
        }
        Eigen::Matrix<double, 3, 3, Eigen::RowMajor> matrix;
        for (std::size_t row = 0; row < 3; ++row) {
            const std::string wrong = read_numbers((*value)[row], {matrix.data() + 3 * row, 3});
            if (wrong.empty()) continue;
            fault(field, wrong + " in row " + std::to_string(row), expected);
            return std::nullopt;
        }
        return matrix;
    }

    std::optional<Vec3> read_vector(const char* field) {
        Vec3 vector;
        const Json* value = find(field);
        const std::string wrong = value ? read_numbers(*value, {vector.data(), 3}) : "missing";
        if (wrong.empty()) return vector;
        fault(field, wrong, "3 finite numbers");
        return std::nullopt;
    }

    Distortion read_distortion() {
        const Json* value = find("distortion");
        if (!value) return {};
        std::array<double, 5> k{};
        const std::size_t n = value->size() == 4 ? 4 : 5;
        const std::string wrong = read_numbers(*value, {k.data(), n});
        if (wrong.empty()) return {k[0], k[1], k[2], k[3], k[4]};
        fault("distortion", wrong, "the 4 or 5 finite numbers k1 k2 p1 p2 k3");
        return {};
    }

    const Json& entry_;
    std::string where_;
    const std::string& file_name_;
    Faults& faults_;
    bool is_well_formed_ = true;
};

Vec2 read_pixel_center(const Json& root, const std::string& name, Faults& faults) {
    const auto member = root.find("pixel_center");
    if (member == root.end()) return CameraList{}.pixel_center;
    Vec2 center;
    const std::string wrong = read_numbers(*member, {center.data(), 2});
    if (wrong.empty() && (center.array() >= 0.0).all() && (center.array() <= 1.0).all()) return center;
    faults.add(name, "pixel_center is " + (wrong.empty() ? "outside the top-left pixel" : wrong) +
                         "; expected 2 numbers from 0 to 1, mostly [0, 0] or [0.5, 0.5]");
    return CameraList{}.pixel_center;
}

Json to_json(const Mat3& matrix) {
    Json rows = Json::array();
    for (int r = 0; r < 3; ++r) rows.push_back({matrix(r, 0), matrix(r, 1), matrix(r, 2)});
    return rows;
}

}  // namespace

CameraList parse_cameras(std::string_view json, const std::string& name, Faults& faults) {
    const Json root = parse_json(json, name);
    if (!root.is_object()) throw_fault(name, "holds " + describe(root) + "; expected an object with a list \"images\"");
    for (const char* list_name : {"images", "cameras", "views", "frames"}) {
        const auto list = root.find(list_name);
        if (list == root.end() || !list->is_array()) continue;
        CameraList result;
        result.pixel_center = read_pixel_center(root, name, faults);
        for (std::size_t i = 0; i < list->size(); ++i) {
            const std::string where = std::string(list_name) + "[" + std::to_string(i) + "]";
            result.entries.push_back(EntryReader((*list)[i], where, name, faults).read());
        }
        return result;
    }
    throw_fault(name, "has no list of photographs; expected \"images\": [...]");
}

std::string format_cameras(const std::vector<View>& views, const std::vector<std::string>& files,
                           const std::vector<std::string>& masks) {
    const Vec2 center{0.5, 0.5};
    std::string text = "{\"pixel_center\": [0.5, 0.5],\n \"images\": [";
    for (std::size_t i = 0; i < views.size(); ++i) {
        const Camera& camera = views[i].camera;
        Mat3 K = camera.K;
        K.block<2, 1>(0, 2) += center;
        nlohmann::ordered_json entry;
        entry["file"] = files[i];
        entry["mask"] = masks[i];
        entry["width"] = camera.width;
        entry["height"] = camera.height;
        entry["K"] = to_json(K);
        entry["R"] = to_json(camera.R);
        entry["t"] = {camera.t.x(), camera.t.y(), camera.t.z()};
        text += (i == 0 ? "\n  " : ",\n  ") + entry.dump();
    }
    return text + "\n ]}\n";
}

}  // namespace anyrate
