#pragma once
#include <boost/asio/async_result.hpp>
#include <boost/asio/post.hpp>
#include <boost/asio/thread_pool.hpp>
#include <exception>
#include <optional>
#include <type_traits>
#include <utility>

#include "server/http/net.h"

namespace anyrate {

/// Runs blocking or long work on a thread pool, so that no network thread waits for it, and gives its result (or throws
/// its exception) back on the coroutine's own executor. The pool must be joined before the coroutine's context goes.
template <class Work>
awaitable<std::invoke_result_t<Work&>> on_pool(asio::thread_pool& pool, Work work) {
    std::optional<std::invoke_result_t<Work&>> result;
    std::exception_ptr error;
    const auto start = [&](auto handler) {
        const auto executor = asio::get_associated_executor(handler);
        asio::post(pool, [&work, &result, &error, executor, handler = std::move(handler)]() mutable {
            try {
                result.emplace(work());
            } catch (...) {
                error = std::current_exception();
            }
            asio::post(executor, std::move(handler));
        });
    };
    co_await asio::async_initiate<const asio::use_awaitable_t<>, void()>(start, use_awaitable);
    if (error) std::rethrow_exception(error);
    co_return std::move(*result);
}

}  // namespace anyrate
