// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0

#include <fmt/format.h>

#include "apps/octant/commands.h"
#include "apps/octant/outputs.h"
#include "apps/octant/steps/steps.h"
#include "io/deployment/signature.h"
#include "io/text/atomic_file.h"
#include "io/text/bounds.h"

namespace octant::app {
namespace {

struct SignArgs {
  std::string deployment, key, output, new_key;
};

int new_key(const SignArgs& args, Session& session) {
  if (!args.deployment.empty() || !args.key.empty() || !args.output.empty())
    fail_usage("--new-key makes a key and signs nothing", "octant sign --help explains");
  need(io::make_key(args.new_key));
  session.result(fmt::format("{:<17}{}: keep it, and to yourself\n{:<17}{}.pub: for those who check\n",
                             "secret key", args.new_key, "public key", args.new_key));
  return session.finish({{"secret_key", args.new_key}, {"public_key", args.new_key + ".pub"}});
}

int sign(const SignArgs& args, Session& session) {
  if (!args.new_key.empty()) return new_key(args, session);
  if (args.deployment.empty() || args.key.empty() || args.output.empty())
    fail_usage("expected DEPLOYMENT.json, --key KEY and -o SIGNED.json, or --new-key FILE",
               "octant sign --help explains");
  check_outputs({args.deployment, args.key}, {{"-o", args.output}}, session);
  const std::string text = need(io::read_document(args.deployment));
  need(io::write_file(args.output, need(io::signed_deployment(text, args.deployment, args.key))));
  session.result(fmt::format("{:<17}{}\n", "signed", args.output));
  return session.finish({{"deployment", args.deployment}, {"written", args.output}});
}

int verify_signature(const SignArgs& args, Session& session) {
  need(io::check_signature(need(io::read_document(args.deployment)), args.deployment, args.key));
  session.result(
      fmt::format("{:<17}{} is as the owner of {} signed it\n", "genuine", args.deployment, args.key));
  return session.finish({{"deployment", args.deployment}, {"key", args.key}, {"genuine", true}});
}

}  // namespace

void add_sign(CLI::App& app, CommonOptions& common, Action& action) {
  const auto [command, args] =
      add_command<SignArgs>(app, common, action, "sign", "Sign a deployment, or make a key to sign with",
                            "octant sign --new-key site.key\n  octant sign hall/deployment.json --key "
                            "site.key -o hall/signed.json",
                            sign);
  add_option(*command, "deployment", args->deployment, "DEPLOYMENT.json", "Deployment file, from calibrate");
  add_option(*command, "--key", args->key, "KEY", "Secret Ed25519 key, PEM");
  add_option(*command, "-o,--output", args->output, "SIGNED.json",
             "Signed deployment to write; - is standard output");
  add_option(*command, "--new-key", args->new_key, "FILE",
             "Instead: make a secret key, and FILE.pub for those who check");
}

void add_verify_signature(CLI::App& app, CommonOptions& common, Action& action) {
  const auto [command, args] = add_command<SignArgs>(
      app, common, action, "verify-signature", "Tell whether a deployment is as the owner of a key signed it",
      "octant verify-signature hall/signed.json --key site.key.pub", verify_signature);
  add_required_option(*command, "deployment", args->deployment, "DEPLOYMENT.json", "Signed deployment");
  add_required_option(*command, "--key,--trusted-key", args->key, "PUB", "Public Ed25519 key, PEM");
}

}  // namespace octant::app
