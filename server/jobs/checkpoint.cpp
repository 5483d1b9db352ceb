#include "server/jobs/checkpoint.h"

#include <string>

#include "core/error.h"
#include "proto/bytes.h"
#include "proto/crc32c.h"

namespace anyrate {
namespace {

constexpr std::uint32_t checkpoint_magic = 0x32504B43;  // "CKP2"
constexpr std::uint32_t mark_magic = 0x314B524D;        // "MRK1"

template <class T, class Put>
void put_all(ByteWriter& out, const std::vector<T>& values, const Put& put) {
    out.put(static_cast<std::uint32_t>(values.size()));
    for (const T& value : values) put(value);
}

/// A count and so many values. @param size  bytes of one, so that no count asks for more than there is
template <class Take>
auto take_all(ByteReader& in, std::size_t size, const Take& take) {
    const auto n = in.take<std::uint32_t>();
    if (n > in.remaining() / size)
        throw DecodeError("checkpoint: expected " + std::to_string(n) + " values of " + std::to_string(size) +
                          " bytes, got " + std::to_string(in.remaining()) + " bytes");
    std::vector<decltype(take())> values;
    values.reserve(n);
    for (std::uint32_t i = 0; i < n; ++i) values.push_back(take());
    return values;
}

void put(ByteWriter& out, const Vec3& v) {
    for (int k = 0; k < 3; ++k) out.put(v[k]);
}
Vec3 take_vec3(ByteReader& in) {
    Vec3 v;
    for (int k = 0; k < 3; ++k) v[k] = in.take<double>();
    return v;
}

void put_triangles(ByteWriter& out, const std::vector<Triangle>& triangles) {
    put_all(out, triangles, [&](const Triangle& t) {
        for (const std::int32_t v : t) out.put(static_cast<std::uint32_t>(v));
    });
}
/// @param n_vertices  below which every corner is
std::vector<Triangle> take_triangles(ByteReader& in, std::size_t n_vertices) {
    return take_all(in, 12, [&] {
        Triangle t;
        for (std::int32_t& v : t) {
            const auto corner = in.take<std::uint32_t>();
            if (corner >= n_vertices)
                throw DecodeError("checkpoint: a corner is vertex " + std::to_string(corner) + " of " +
                                  std::to_string(n_vertices));
            v = static_cast<std::int32_t>(corner);
        }
        return t;
    });
}

void put(ByteWriter& out, const Grid& grid) {
    put(out, grid.origin);
    out.put(grid.unit);
    out.put(static_cast<std::uint32_t>(grid.bits));
    out.put(static_cast<std::uint32_t>(grid.base_shift));
}
Grid take_grid(ByteReader& in) {
    Grid grid;
    grid.origin = take_vec3(in);
    grid.unit = in.take<double>();
    grid.bits = static_cast<std::int32_t>(in.take<std::uint32_t>());
    grid.base_shift = static_cast<std::int32_t>(in.take<std::uint32_t>());
    return grid;
}

void put(ByteWriter& out, const BaseMesh& base) {
    put_all(out, base.positions, [&](const GridPoint& p) {
        for (const std::int32_t c : {p.x, p.y, p.z}) out.put(static_cast<std::uint32_t>(c));
    });
    put_triangles(out, base.triangles);
}
BaseMesh take_base(ByteReader& in) {
    const auto coordinate = [&] { return static_cast<std::int32_t>(in.take<std::uint32_t>()); };
    BaseMesh base;
    base.positions = take_all(in, 12, [&] {
        GridPoint p;
        p.x = coordinate();
        p.y = coordinate();
        p.z = coordinate();
        return p;
    });
    base.triangles = take_triangles(in, base.positions.size());
    return base;
}

void put(ByteWriter& out, const std::vector<Vec2>& shifts) {
    put_all(out, shifts, [&](const Vec2& shift) {
        out.put(shift.x());
        out.put(shift.y());
    });
}
std::vector<Vec2> take_shifts(ByteReader& in) {
    return take_all(in, 16, [&] {
        const auto x = in.take<double>();
        return Vec2(x, in.take<double>());
    });
}

std::vector<std::byte> with_checksum(ByteWriter out) {
    out.put(crc32c(out.bytes()));
    return out.take();
}

/// The bytes between magic number and checksum, once both are right.
std::span<const std::byte> checked(std::span<const std::byte> bytes, std::uint32_t magic, const char* what) {
    constexpr std::size_t frame = 2 * sizeof(std::uint32_t);
    if (bytes.size() < frame) throw DecodeError(std::string(what) + ": cut off");
    const auto body = bytes.first(bytes.size() - sizeof(std::uint32_t));
    if (ByteReader(body, what).take<std::uint32_t>() != magic)
        throw DecodeError(std::string(what) + ": of another version, or none at all");
    if (ByteReader(bytes.subspan(body.size()), what).take<std::uint32_t>() != crc32c(body))
        throw DecodeError(std::string(what) + ": damaged, its checksum is another");
    return body.subspan(sizeof(std::uint32_t));
}

void expect_end(const ByteReader& in, const char* what) {
    if (in.remaining() != 0)
        throw DecodeError(std::string(what) + ": " + std::to_string(in.remaining()) + " bytes too many");
}

}  // namespace

std::vector<std::byte> encode_checkpoint(const Checkpoint& checkpoint) {
    const RefinementStart& start = checkpoint.start;
    ByteWriter out;
    out.put(checkpoint_magic);
    out.put(checkpoint.log_id);
    put(out, start.grid);
    put(out, start.base);
    put_all(out, start.gains, [&](const Gains& gains) {
        for (const double gain : gains) out.put(gain);
    });
    put_all(out, start.shifts, [&](const std::vector<Vec2>& shifts) { put(out, shifts); });
    out.put(start.mask_growth_px);
    put_all(out, start.guess_points, [&](const OrientedPoint& point) {
        put(out, point.position);
        put(out, point.normal);
        out.put(point.area);
    });
    out.put(start.guess_reach);
    put_all(out, start.fitted.vertices, [&](const Vec3& vertex) { put(out, vertex); });
    put_triangles(out, start.fitted.triangles);
    return with_checksum(std::move(out));
}

Checkpoint decode_checkpoint(std::span<const std::byte> bytes) {
    constexpr const char* what = "checkpoint";
    ByteReader in(checked(bytes, checkpoint_magic, what), what);
    Checkpoint checkpoint;
    RefinementStart& start = checkpoint.start;
    checkpoint.log_id = in.take<std::uint64_t>();
    start.grid = take_grid(in);
    start.base = take_base(in);
    start.gains = take_all(in, 24, [&] {
        Gains gains{};
        for (double& gain : gains) gain = in.take<double>();
        return gains;
    });
    start.shifts = take_all(in, 4, [&] { return take_shifts(in); });
    start.mask_growth_px = in.take<double>();
    start.guess_points = take_all(in, 56, [&] {
        OrientedPoint point;
        point.position = take_vec3(in);
        point.normal = take_vec3(in);
        point.area = in.take<double>();
        return point;
    });
    start.guess_reach = in.take<double>();
    start.fitted.vertices = take_all(in, 24, [&] { return take_vec3(in); });
    start.fitted.triangles = take_triangles(in, start.fitted.vertices.size());
    expect_end(in, what);
    return checkpoint;
}

std::vector<std::byte> encode_mark(const LogMark& mark) {
    ByteWriter out;
    out.put(mark_magic);
    out.put(mark.n_bytes);
    out.put(mark.n_rows);
    out.put(mark.seconds);
    put_all(out, mark.is_rejected, [&](char flag) { out.put(static_cast<std::uint8_t>(flag)); });
    return with_checksum(std::move(out));
}

LogMark decode_mark(std::span<const std::byte> bytes) {
    constexpr const char* what = "log mark";
    ByteReader in(checked(bytes, mark_magic, what), what);
    LogMark mark;
    mark.n_bytes = in.take<std::uint64_t>();
    mark.n_rows = in.take<std::uint32_t>();
    mark.seconds = in.take<double>();
    mark.is_rejected = take_all(in, 1, [&] { return static_cast<char>(in.take<std::uint8_t>()); });
    expect_end(in, what);
    return mark;
}

}  // namespace anyrate
