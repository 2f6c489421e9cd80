//! A station of the token ring (nodes/zoo) in Rust, as WIRE.md tells: `reference-node s1.ticket`.

use rmpv::Value;
use std::time::Duration;
use zenoh::handlers::FifoChannel;
use zenoh::qos::CongestionControl;
use zenoh::sample::SampleKind;
use zenoh::Wait;

const WIRE: u64 = 1;
const HEAD: usize = 23; // bytes of a frame before its names
const FOREVER: Tag = (i64::MAX as u64, 0);

type Tag = (u64, u64);
type Anything = Box<dyn std::error::Error + Send + Sync>;

fn after(tag: Tag, wait: u64, steps: u64) -> Tag {
    if wait > 0 { (tag.0 + wait, 0) } else { (tag.0, tag.1 + steps) }
}

fn tag_of(value: &Value) -> Tag {
    (value[0].as_u64().unwrap(), value[1].as_u64().unwrap())
}

fn value_of(tag: Tag) -> Value {
    Value::Array(vec![tag.0.into(), tag.1.into()])
}

fn packed(value: &Value) -> Vec<u8> {
    let mut bytes = Vec::new();
    rmpv::encode::write_value(&mut bytes, value).unwrap();
    bytes
}

fn unpacked(mut bytes: &[u8]) -> Value {
    rmpv::decode::read_value(&mut bytes).unwrap()
}

fn field<'a>(map: &'a Value, name: &str) -> &'a Value {
    let pairs = map.as_map().unwrap();
    &pairs.iter().find(|(key, _)| key.as_str() == Some(name)).unwrap().1
}

/// An input: its tag, source, port and index, which are its place in the total order, and its token.
type Input = (Tag, String, String, u64, u64);

fn input_of(event: &Value) -> Input {
    let payload = unpacked(event[6].as_slice().unwrap());
    let (source, port) = (event[2].as_str().unwrap(), event[3].as_str().unwrap());
    let number = field(&payload, "number").as_u64().unwrap();
    let tag = (event[0].as_u64().unwrap(), event[1].as_u64().unwrap());
    (tag, source.into(), port.into(), event[4].as_u64().unwrap(), number)
}

/// Holds what arrives together for `hold` [ns], then passes it on.
struct Station {
    name: String,
    hold: u64,
    tokens: Vec<u64>,
    next: Tag,
    kept: Vec<Input>, // inputs that it has not reached
}

impl Station {
    fn new(name: &str, parameters: &Value) -> Station {
        let hold = field(parameters, "hold").as_u64().unwrap();
        let first = field(parameters, "first");
        let tokens = if first.is_nil() { vec![] } else { vec![field(first, "number").as_u64().unwrap()] };
        let next = if first.is_nil() { FOREVER } else { (hold, 0) };
        Station { name: name.into(), hold, tokens, next, kept: vec![] }
    }

    /// Lambda: [t, k, model, port, index, type, payload] of each token in hand.
    fn outputs(&self) -> Vec<Value> {
        let said = self.tokens.iter().enumerate();
        said.map(|(index, &number)| {
            let payload = packed(&Value::Map(vec![("number".into(), number.into())]));
            let (name, at) = (self.name.as_str(), self.next);
            let what = [at.0.into(), at.1.into(), name.into(), "out".into(), index.into(), "Token".into()];
            Value::Array([&what[..], &[Value::Binary(payload)]].concat())
        })
        .collect()
    }

    /// Internal, external, or one after the other.
    fn transition(&mut self, tag: Tag, bag: Vec<Input>) {
        if tag == self.next {
            self.tokens.clear();
        }
        self.next = if bag.is_empty() { FOREVER } else { after(tag, self.hold, 1) };
        self.tokens.extend(bag.iter().map(|input| input.4));
    }

    /// Next, offer, quiet.
    fn present(&self) -> [Value; 3] {
        [value_of(self.next), Value::Array(self.outputs()), value_of(self.next)]
    }

    /// Steps 8 to 10 of PROTOCOL.md.
    fn done(&mut self, grant: &Value) -> Value {
        let (mut stop, echo) = (tag_of(&grant[2]), &grant[3]);
        let (mut offered, mut spoken) = (grant[4].as_bool().unwrap(), vec![]);
        self.kept.extend(grant[5].as_array().unwrap().iter().map(input_of));
        self.kept.sort();
        loop {
            let tag = self.kept.first().map_or(self.next, |input| self.next.min(input.0));
            if tag >= stop {
                break;
            }
            if tag == self.next {
                let back = if echo.is_nil() { FOREVER } else { tag_of(echo) };
                let back = if echo.is_nil() { back } else { after(tag, back.0, back.1) };
                stop = stop.min(back.max(after(tag, 0, 1)));
                if !offered {
                    spoken.extend(self.outputs());
                }
            }
            offered = false;
            let heard = self.kept.iter().take_while(|input| input.0 == tag).count();
            let bag = self.kept.drain(..heard).collect();
            self.transition(tag, bag);
        }
        let [next, offer, quiet] = self.present();
        let reached = value_of(stop);
        Value::Array(vec!["done".into(), grant[1].clone(), reached, spoken.into(), next, offer, quiet, bytes(&[])])
    }
}

fn bytes(what: &[u8]) -> Value {
    Value::Binary(what.to_vec())
}

/// A frame as the table of WIRE.md has it; `names`: the run and the node.
fn framed(number: u64, topic: u8, epoch: u32, names: (&str, &str), message: &[u8]) -> Vec<u8> {
    let mut body = number.to_le_bytes().to_vec();
    body.extend(b"HLF1");
    body.push(topic);
    body.extend(epoch.to_le_bytes());
    body.extend([names.0.len() as u8, names.1.len() as u8]);
    body.extend([names.0.as_bytes(), names.1.as_bytes(), message].concat());
    [&crc32fast::hash(&body).to_le_bytes()[..], &body].concat()
}

fn main() -> Result<(), Anything> {
    let path = std::env::args().nth(1).ok_or("say which ticket: reference-node s1.ticket")?;
    let ticket: serde_json::Value = serde_json::from_str(&std::fs::read_to_string(path)?)?;
    if ticket["wire"] != WIRE {
        return Err(format!("this program speaks wire {WIRE}, the run wire {}", ticket["wire"]).into());
    }
    let text = |name: &str| ticket[name].as_str().unwrap().to_string();
    let (run, process, epoch) = (text("run"), text("process"), ticket["epoch"].as_u64().unwrap() as u32);
    let node = ticket["nodes"].as_object().unwrap().keys().next().unwrap().clone();
    let names = (run.as_str(), node.as_str());
    let key = format!("heavylift/{run}");

    let config = serde_json::json!({
        "mode": "client",
        "connect": {"endpoints": [format!("unixsock-stream/{}", text("socket"))]},
        "transport": {"auth": {"usrpwd": {"user": process, "password": text("password")}}},
    });
    let session = zenoh::open(zenoh::Config::from_json5(&config.to_string())?).wait()?;
    let out = session.declare_publisher(format!("{key}/out/{process}/{node}"));
    let out = out.congestion_control(CongestionControl::Block).wait()?;
    let inbox = session.declare_subscriber(format!("{key}/in/{process}/{node}"));
    let inbox = inbox.with(FifoChannel::new(4096)).wait()?;
    let hub = session.liveliness().declare_subscriber(format!("{key}/alive/~hub"));
    let _hub = hub.callback(|sample| if sample.kind() == SampleKind::Delete { std::process::exit(86) }).wait()?;
    while !out.matching_status().wait()?.matching() {
        std::thread::sleep(Duration::from_millis(1));
    }
    let _token = session.liveliness().declare_token(format!("{key}/alive/{process}/{epoch}")).wait()?;

    let mut station: Option<Station> = None;
    for number in 0u64.. {
        let frame = inbox.recv()?.payload().to_bytes().to_vec();
        let payload = frame[(HEAD + run.len() + node.len())..].to_vec();
        if frame != framed(number, 0, epoch, names, &payload) {
            return Err("what has arrived is not the next message of this run".into());
        }
        let message = unpacked(&payload);
        let kind = message[0].as_str().unwrap().to_string();
        let answer = match kind.as_str() {
            "welcome" => {
                let config = unpacked(message[2].as_slice().unwrap());
                let parameters = field(field(field(&config, "models"), &node), "parameters");
                let [next, offer, quiet] = station.insert(Station::new(&node, parameters)).present();
                let lookahead = Value::Map(vec![(format!("{node}.out").into(), 0.into())]);
                vec!["hello".into(), next, offer, quiet, lookahead, bytes(&[]), format!("wire {WIRE}").into()]
            }
            "grant" => match station.as_mut().ok_or("a GRANT before WELCOME")?.done(&message) {
                Value::Array(fields) => fields,
                _ => unreachable!("a DONE is an array"),
            },
            "stop" => vec!["bye".into()],
            _ => vec!["checkpoint".into(), message[1].clone(), bytes(&[]), "no state is kept".into()],
        };
        out.put(framed(number, 1, epoch, names, &packed(&Value::Array(answer)))).wait()?;
        if kind == "stop" {
            let left = session.get(format!("{key}/leave/{process}")).timeout(Duration::from_secs(2)).wait()?;
            while left.recv().is_ok() {} // answered when all that was sent is there
            session.close().wait()?;
            return Ok(());
        }
    }
    unreachable!("numbers end after the run")
}
