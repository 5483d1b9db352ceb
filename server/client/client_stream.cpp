#include "server/client/client_stream.h"

#include <boost/asio/ip/address.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/post.hpp>
#include <string>

#include "core/error.h"

namespace anyrate {
namespace {

namespace asio = boost::asio;
namespace ssl = asio::ssl;
using ErrorCode = boost::system::error_code;

ssl::context trust_of(const ServerAccess& access) {
    ssl::context trust(ssl::context::tls_client);
    trust.set_options(ssl::context::default_workarounds | ssl::context::no_tlsv1 | ssl::context::no_tlsv1_1);
    ErrorCode error;
    if (access.ca.empty())
        trust.set_default_verify_paths(error);
    else
        trust.load_verify_file(access.ca.string(), error);
    if (error) throw InputError(access.ca.string() + ": expected certificates in PEM: " + error.message());
    return trust;
}

bool is_address(const std::string& host) {
    ErrorCode error;
    asio::ip::make_address(host, error);
    return !error;
}

}  // namespace

ClientStream::ClientStream(asio::io_context& io, const Url& server, const ServerAccess& access)
    : io_(io), server_(server), tcp_(io) {
    if (!server.is_secure) return;
    trust_.emplace(trust_of(access));
    tls_ = std::make_unique<ssl::stream<boost::beast::tcp_stream&>>(tcp_, *trust_);
    tls_->set_verify_mode(ssl::verify_peer);
    SSL* handle = tls_->native_handle();
    if (is_address(server.host)) {
        X509_VERIFY_PARAM_set1_ip_asc(SSL_get0_param(handle), server.host.c_str());
    } else {
        SSL_set1_host(handle, server.host.c_str());
        SSL_set_tlsext_host_name(handle, server.host.c_str());  // a server may have a certificate for each of its names
    }
}

template <class Start>
ErrorCode ClientStream::run(const Start& start) {
    ErrorCode result = asio::error::would_block;
    start([&result](ErrorCode error, auto&&...) { result = error; });
    io_.restart();
    io_.run();
    return result;
}

void ClientStream::connect(std::chrono::seconds patience) {
    const auto expect = [this](ErrorCode error, const std::string& what) {
        if (error) throw IoError("cannot " + what + " " + server_.authority() + ": " + error.message());
    };
    asio::ip::tcp::resolver resolver(io_);
    ErrorCode error;
    const auto addresses = resolver.resolve(server_.host, server_.port, error);
    expect(error, "find");
    expires_after(patience);
    expect(run([&](auto done) { tcp_.async_connect(addresses, std::move(done)); }), "connect to");
    tcp_.socket().set_option(asio::ip::tcp::no_delay(true));
    if (!tls_) return;
    expires_after(patience);
    error = run([&](auto done) { tls_->async_handshake(ssl::stream_base::client, std::move(done)); });
    if (const long verdict = SSL_get_verify_result(tls_->native_handle()); error && verdict != X509_V_OK)
        throw UntrustedServer("the certificate of " + server_.authority() + " is not to be trusted: " +
                              X509_verify_cert_error_string(verdict) + " (--ca names certificates to trust)");
    expect(error, "agree on TLS with");
}

}  // namespace anyrate
