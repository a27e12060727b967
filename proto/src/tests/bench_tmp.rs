//! tmp
use super::fake::{Pair, soon};
use sph::driver::{Command, Event};
#[tokio::test(flavor = "multi_thread")]
async fn bench() {
    let mut pair = Pair::linked("run", 20_000).await;
    let (fc, mut fe) = pair.fluid.run().await.unwrap();
    let (sc, mut se) = pair.solid.run().await.unwrap();
    let t = std::time::Instant::now();
    fc.send(Command::GrantThrough(20_000)).unwrap();
    sc.send(Command::GrantThrough(20_000)).unwrap();
    let h = tokio::spawn(async move { while let Some(e) = se.recv().await { e.unwrap(); } });
    let (mut waited, mut elapsed) = (0.0, 0.0);
    while let Some(e) = soon("x", fe.recv()).await { if let Event::Step(s) = e.unwrap() { waited += s.waited; elapsed += s.elapsed; } }
    h.await.unwrap();
    println!("per half-step {:.1} us, waited {:.1} us, elapsed {:.1}", t.elapsed().as_secs_f64() / 40_000.0 * 1e6, waited / 40_000.0 * 1e6, elapsed / 40_000.0 * 1e6);
}
