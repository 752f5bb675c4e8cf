// The grammar of one item: a declaration or a rule with its full stop. parse.cpp calls it once per item.
%require "3.8"
%language "c++"
%skeleton "lalr1.cc"
%define api.namespace {meld::syntax::grammar}
%define api.parser.class {Parser}
%define api.value.type variant
%define api.value.automove
%define api.token.constructor
%define api.location.type {meld::source::Span}
%define api.token.prefix {Token}
%define parse.error custom
%define parse.lac full

%code requires {
#include "compiler/syntax/item_parser.h"
}

%param { meld::syntax::ItemTokens& tokens }
%parse-param { meld::syntax::Builder& build }

%code {
#define YYLLOC_DEFAULT(Current, Rhs, N)                                              \
    do {                                                                             \
        if (N) {                                                                     \
            (Current) = YYRHSLOC(Rhs, 1).to(YYRHSLOC(Rhs, N));                       \
        } else {                                                                     \
            (Current) = YYRHSLOC(Rhs, 0);                                            \
            (Current).begin = (Current).end;                                         \
        }                                                                            \
    } while (false)

namespace meld::syntax::grammar {

using Form = DeclarationWord::Form;

static Parser::symbol_type yylex(ItemTokens& tokens);

template <class T>
static std::vector<T> list_of(T first) {
    std::vector<T> list;
    list.push_back(std::move(first));
    return list;
}

template <class T>
static std::vector<T> with(std::vector<T> list, T next) {
    list.push_back(std::move(next));
    return list;
}

static DeclarationWord number_word(const Token& token) { return {Form::Number, token.text, {}, token.span, token.integer}; }

}  // namespace meld::syntax::grammar
}

%token <const Token*>
  End 0 Name Variable Anonymous Int Float String Catom World RunArgument AtName Delay Period ExistsPeriod Comma Semicolon Bar
  LeftParen RightParen LeftBracket RightBracket LeftBrace RightBrace StructOpen NeighbourOpen Colon Cons
  ViewArrow LinearArrow ResultArrow LastArrow
  Equal NotEqual Less LessEqual Greater GreaterEqual And Or Tilde Plus Minus Star Slash Percent Caret Append Bang Question Dollar
  Type Const Fun Extern Node Import Export Module Hint If Then Else Otherwise EndWord Let In Not Forall Exists Delta
  Aggregate SizedAggregate
  Include IncludePath Use

// Loosest first.
%left Or
%left And
%precedence Tilde
%nonassoc Equal NotEqual Less LessEqual Greater GreaterEqual
%right Cons
%right Append
%left Plus Minus
%left Star Slash Percent
%precedence Negation
%right Caret

%nterm <ExprPtr> expr primary list aggregate_value initial
%nterm <std::vector<ExprPtr>> exprs exprs_opt
%nterm <meld::syntax::Atom> call atom
%nterm <Part> part
%nterm <std::vector<Part>> parts parts_opt
%nterm <std::vector<std::vector<Part>>> sections aggregate_sections
%nterm <Bracketed> bracketed
%nterm <std::vector<HeadAggregate>> selections
%nterm <HeadAggregate> selection
%nterm <HeadIf> head_if
%nterm <std::vector<meld::syntax::Name>> variables
%nterm <meld::syntax::BinaryOp> compare
%nterm <DeclarationWord> word
%nterm <DeclarationWords> words
%nterm <std::vector<DeclarationWords>> arguments arguments_opt
%nterm <const Token*> constant_name hint_word
%nterm <std::vector<const Token*>> hint_words

%start item

%%

item:
    Type words Period                       { build.type_item($2, @1.to(@2)); }
  | Const constant_name Equal expr Period   { build.item(Constant{Builder::to_name(*$2), $4, @1.to(@4)}); }
  | Fun Name LeftParen arguments_opt RightParen Colon words Equal expr Period
                                            { build.function(*$2, $4, $7, $9, @1.to(@9)); }
  | Fun Name LeftParen arguments_opt RightParen StructOpen arguments RightParen Equal expr Period
                                            { DeclarationWord pair{Form::Group, "", $7, @6.to(@8)};
                                              build.function(*$2, $4, {std::move(pair)}, $10, @1.to(@10)); }
  | Extern words Period                     { build.extern_item($2, @1.to(@2)); }
  | Node Name Period                        { build.item(NodeKind{Builder::to_name(*$2), @1.to(@2)}); }
  | Import words Period                     { build.import_item($2, @1.to(@2)); }
  | Export Name Period                      { build.item(Export{Builder::to_name(*$2), @1.to(@2)}); }
  | Module Name Period                      { build.item(Module{Builder::to_name(*$2), @1.to(@2)}); }
  | Hint hint_words Period                  { build.hint(*$1, $2, @1.to(@2)); }
  | parts Period                            { build.rule(Arrow::Axiom, {}, $1, @1); }
  | parts ViewArrow parts Period            { build.rule(Arrow::View, $3, $1, @1.to(@3)); }
  | parts LinearArrow parts Period          { build.rule(Arrow::Linear, $1, $3, @1.to(@3)); }
  | parts LinearArrow Period                { build.rule(Arrow::Linear, $1, {}, @1.to(@2)); }
  ;

constant_name: Name | Variable ;

// ---- declarations: words and brackets, read by DeclarationReader

words:
    word        { $$ = list_of($1); }
  | words word  { $$ = with($1, $2); }
  ;

word:
    Name                                   { $$ = {Form::Name, $1->text, {}, @$}; }
  | Variable                               { $$ = {Form::Variable, $1->text, {}, @$}; }
  | String                                 { $$ = {Form::Text, $1->text, {}, @$}; }
  | Int                                    { $$ = number_word(*$1); }
  | LeftParen arguments_opt RightParen     { $$ = {Form::Group, "", $2, @$}; }
  | StructOpen arguments RightParen        { $$ = {Form::Struct, "", $2, @$}; }
  | NeighbourOpen Name RightBracket        { $$ = {build.is_outgoing(*$1) ? Form::OutNeighbour : Form::Neighbour, $2->text, {}, @$}; }
  ;

arguments_opt:
    %empty     { }
  | arguments
  ;

arguments:
    words                  { $$ = list_of($1); }
  | arguments Comma words  { $$ = with($1, $3); }
  ;

hint_words:
    hint_word             { $$ = list_of($1); }
  | hint_words hint_word  { $$ = with($1, $2); }
  ;

hint_word:
    Name | Variable | Int | Float | String | AtName | Catom | Less | Greater | Slash | Comma | Colon | Equal | Minus
  | LeftParen | RightParen | LeftBracket | RightBracket
  ;

// ---- bodies and heads

parts_opt:
    %empty  { }
  | parts
  ;

parts:
    part              { $$ = list_of($1); }
  | parts Comma part  { $$ = with($1, $3); }
  ;

part:
    expr                                  { $$ = Part{$1, {}, @$}; }
  | expr Delay                            { $$ = Part{$1, build.delay(*$2), @$}; }
  | Bang call                             { $$ = Part{with_sigil($2, Sigil::Persistent, @$), {}, @$}; }
  | Question call                         { $$ = Part{with_sigil($2, Sigil::Linear, @$), {}, @$}; }
  | Dollar call                           { $$ = Part{with_sigil($2, Sigil::Read, @$), {}, @$}; }
  | Bang call Delay                       { $$ = Part{with_sigil($2, Sigil::Persistent, @1.to(@2)), build.delay(*$3), @$}; }
  | Question call Delay                   { $$ = Part{with_sigil($2, Sigil::Linear, @1.to(@2)), build.delay(*$3), @$}; }
  | Not atom                              { Span inner = @2; $$ = Part{meld::syntax::Not{list_of(Clause{$2, inner})}, {}, @$}; }
  | Not LeftParen parts RightParen        { $$ = Part{meld::syntax::Not{build.clauses($3)}, {}, @$}; }
  | Forall atom LeftBracket parts RightBracket
                                          { $$ = Part{meld::syntax::Forall{$2, build.clauses($4)}, {}, @$}; }
  | expr In expr                          { $$ = build.element($1, $3, @$); }
  | Delta LeftParen Variable Semicolon atom RightParen compare expr
                                          { $$ = Part{meld::syntax::Delta{Builder::to_name(*$3), $5, $7, $8}, {}, @$}; }
  | expr Equal Aggregate aggregate_value Colon LeftBrace parts RightBrace
                                          { $$ = Part{build.body_aggregate($1, *$3, nullptr, $4, build.clauses($7)), {}, @$}; }
  | expr Equal SizedAggregate LeftParen expr RightParen expr Colon LeftBrace parts RightBrace
                                          { $$ = Part{build.body_aggregate($1, *$3, $5, $7, build.clauses($10)), {}, @$}; }
  | LeftBrace sections RightBrace         { $$ = Part{build.comprehension($2, @$), {}, @$}; }
  | LeftBrace sections LinearArrow parts_opt RightBrace
                                          { $$ = Part{build.comprehension(with($2, $4), @$), {}, @$}; }
  | bracketed                             { $$ = Part{$1, {}, @$}; }
  | Exists variables ExistsPeriod LeftParen parts RightParen
                                          { $$ = Part{meld::syntax::Exists{$2, build.heads($5)}, {}, @$}; }
  | head_if                               { $$ = Part{$1, {}, @$}; }
  | LeftParen head_if RightParen          { $$ = Part{$2, {}, @$}; }
  ;

atom:
    call
  | Bang call      { $$ = with_sigil($2, Sigil::Persistent, @$); }
  | Question call  { $$ = with_sigil($2, Sigil::Linear, @$); }
  | Dollar call    { $$ = with_sigil($2, Sigil::Read, @$); }
  ;

call: Name LeftParen exprs_opt RightParen  { $$ = Atom{Sigil::None, Builder::to_name(*$1), $3, @$}; } ;

compare:
    Equal         { $$ = BinaryOp::Equal; }
  | NotEqual      { $$ = BinaryOp::NotEqual; }
  | Less          { $$ = BinaryOp::Less; }
  | LessEqual     { $$ = BinaryOp::LessEqual; }
  | Greater       { $$ = BinaryOp::Greater; }
  | GreaterEqual  { $$ = BinaryOp::GreaterEqual; }
  ;

aggregate_value:
    %empty  { }
  | expr
  ;

head_if:
    If expr Then parts Otherwise parts EndWord  { $$ = HeadIf{$2, build.heads($4), build.heads($6)}; }
  | If expr Then parts EndWord                  { $$ = HeadIf{$2, build.heads($4), {}}; }
  ;

// `create B C. (...)` has them without commas.
variables:
    Variable                  { $$ = list_of(Builder::to_name(*$1)); }
  | variables Comma Variable  { $$ = with($1, Builder::to_name(*$3)); }
  | variables Variable        { $$ = with($1, Builder::to_name(*$2)); }
  ;

sections:
    parts_opt               { $$ = list_of($1); }
  | sections Bar parts_opt  { $$ = with($1, $3); }
  ;

bracketed:
    LeftBracket selections Bar aggregate_sections RightBracket        { $$ = Bracketed{$2, $4}; }
  | LeftBracket selections Semicolon aggregate_sections RightBracket  { $$ = Bracketed{$2, $4}; }
  ;

aggregate_sections:
    sections
  | sections LinearArrow parts_opt LastArrow parts_opt  { $$ = with(with($1, $3), $5); }
  ;

selections:
    selection                   { $$ = list_of($1); }
  | selections Comma selection  { $$ = with($1, $3); }
  ;

selection:
    Name ResultArrow Variable               { $$ = HeadAggregate{$1->text, "", nullptr, Builder::to_name(*$3)}; }
  | Name Name initial ResultArrow Variable  { $$ = HeadAggregate{$1->text, $2->text, $3, Builder::to_name(*$5)}; }
  | call ResultArrow Variable               { $$ = build.sized_aggregate($1, *$3); }
  | Colon Name Variable                     { $$ = HeadAggregate{$2->text, "", nullptr, Builder::to_name(*$3)}; }
  ;

initial:
    %empty  { }
  | expr
  ;

// ---- expressions

exprs_opt:
    %empty  { }
  | exprs
  ;

exprs:
    expr              { $$ = list_of($1); }
  | exprs Comma expr  { $$ = with($1, $3); }
  ;

expr:
    primary
  | expr Or expr            { $$ = build.binary(BinaryOp::Or, $1, $3, @$); }
  | expr And expr           { $$ = build.binary(BinaryOp::And, $1, $3, @$); }
  | expr Equal expr         { $$ = build.binary(BinaryOp::Equal, $1, $3, @$); }
  | expr NotEqual expr      { $$ = build.binary(BinaryOp::NotEqual, $1, $3, @$); }
  | expr Less expr          { $$ = build.binary(BinaryOp::Less, $1, $3, @$); }
  | expr LessEqual expr     { $$ = build.binary(BinaryOp::LessEqual, $1, $3, @$); }
  | expr Greater expr       { $$ = build.binary(BinaryOp::Greater, $1, $3, @$); }
  | expr GreaterEqual expr  { $$ = build.binary(BinaryOp::GreaterEqual, $1, $3, @$); }
  | expr Cons expr          { $$ = build.cons($1, $3, @$); }
  | expr Append expr        { $$ = build.binary(BinaryOp::Append, $1, $3, @$); }
  | expr Plus expr          { $$ = build.binary(BinaryOp::Add, $1, $3, @$); }
  | expr Minus expr         { $$ = build.binary(BinaryOp::Subtract, $1, $3, @$); }
  | expr Star expr          { $$ = build.binary(BinaryOp::Multiply, $1, $3, @$); }
  | expr Slash expr         { $$ = build.binary(BinaryOp::Divide, $1, $3, @$); }
  | expr Percent expr       { $$ = build.binary(BinaryOp::Modulo, $1, $3, @$); }
  | expr Caret expr         { $$ = build.binary(BinaryOp::Power, $1, $3, @$); }
  | Minus expr %prec Negation  { $$ = build.negate($2, @$); }
  | Plus Int %prec Negation    { $$ = build.positive(*$2, @$); }
  | Tilde expr                 { $$ = build.expr(Unary{UnaryOp::Not, $2}, @$); }
  ;

primary:
    Int                                      { $$ = build.literal(*$1); }
  | Float                                    { $$ = build.literal(*$1); }
  | String                                   { $$ = build.literal(*$1); }
  | Catom                                    { $$ = build.literal(*$1); }
  | RunArgument                              { $$ = build.literal(*$1); }
  | World                                    { $$ = build.literal(*$1); }
  | AtName                                   { $$ = build.at_name(*$1); }
  | Anonymous                                { $$ = build.literal(*$1); }
  | Variable                                 { $$ = build.expr(meld::syntax::Variable{$1->text}, @$); }
  | Name                                     { $$ = build.name(*$1); }
  | call                                     { $$ = build.call($1); }
  | LeftParen exprs RightParen               { $$ = build.paren_or_tuple($2, @$); }
  | StructOpen exprs RightParen              { $$ = build.expr(StructValue{$2}, @$); }
  | list
  | If expr Then expr Else expr EndWord      { $$ = build.expr(Conditional{$2, $4, $6}, @$); }
  | Let Variable Equal expr In expr EndWord  { $$ = build.expr(meld::syntax::Let{Builder::to_name(*$2), $4, $6}, @$); }
  ;

list:
    LeftBracket RightBracket                 { $$ = build.expr(ListValue{}, @$); }
  | LeftBracket exprs RightBracket           { $$ = build.expr(ListValue{$2, nullptr}, @$); }
  | LeftBracket exprs Bar expr RightBracket  { $$ = build.expr(ListValue{$2, $4}, @$); }
  ;

%%

namespace meld::syntax::grammar {

static Parser::symbol_type yylex(ItemTokens& tokens) {
    const Token& token = tokens.next();
    switch (token.kind) {
#define MELD_TOKEN(name, description) \
    case TokenKind::name: return Parser::symbol_type(Parser::token::Token##name, &token, token.span);
#include "compiler/syntax/tokens.def"
#undef MELD_TOKEN
    }
    return Parser::symbol_type(Parser::token::TokenEnd, &token, token.span);
}

// Bison calls the token 0 YYEOF, whatever its name.
#define S_End S_YYEOF
static TokenKind kind_of(Parser::symbol_kind_type symbol) {
    switch (symbol) {
#define MELD_TOKEN(name, description) \
    case Parser::symbol_kind::S_##name: return TokenKind::name;
#include "compiler/syntax/tokens.def"
#undef MELD_TOKEN
        default: return TokenKind::End;
    }
}

void Parser::report_syntax_error(const context& where) const {
    symbol_kind_type symbols[YYNTOKENS];
    const int count = where.expected_tokens(symbols, YYNTOKENS);
    std::vector<TokenKind> expected;
    for (int i = 0; i < count; ++i) expected.push_back(kind_of(symbols[i]));
    tokens.fail(std::move(expected));
}

void Parser::error(const location_type&, const std::string&) { tokens.fail({}); }

}  // namespace meld::syntax::grammar

namespace meld::syntax {

ItemParser::ItemParser(const std::vector<Token>& tokens, Builder& build)
    : item_(tokens), parser_(std::make_unique<grammar::Parser>(item_, build)) {}

ItemParser::~ItemParser() = default;

bool ItemParser::parse(std::size_t begin, std::optional<std::size_t> stop) {
    item_.start(begin, stop);
    return parser_->parse() == 0;
}

}  // namespace meld::syntax
